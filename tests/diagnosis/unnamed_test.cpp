#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "support/simulated.hpp"
#include "diagnosis/search/shape_words.hpp"
#include "diagnosis/search/tables.hpp"
#include "diagnosis/search/vibration.hpp"
#include "model/correlated_joints.hpp"
#include "simulation/simulation_support.hpp"
#include "veridyn/diagnosis/diagnosis.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/files/model_file.hpp"

// Dependence of a residual on signals, in words and as a table of the model.

namespace veridyn {
namespace {

UnnamedShape shape_along(double low, double high, double (*curve)(double)) {
  UnnamedShape out;
  for (int k = 0; k <= 40; ++k) {
    CurvePoint p;
    p.at = {low + (high - low) * k / 40};
    p.value = curve(p.at.front());
    out.curve.push_back(p);
  }
  return out;
}

MotionSignal signal(SignalKind kind, double low, double high) {
  MotionSignal s;
  s.kind = kind;
  s.joint = 0;
  s.unit = "rad";
  s.low = low;
  s.high = high;
  return s;
}

std::string words(SignalKind kind, double low, double high, double (*curve)(double)) {
  return shape_words(shape_along(low, high, curve), {signal(kind, low, high)});
}

TEST(ShapeWords, DescribeTheCurve) {
  const auto starts = [](const std::string& text, const char* with) { return text.find(with) != std::string::npos; };
  EXPECT_TRUE(starts(words(SignalKind::kPosition, -1, 1, [](double x) { return std::max(0.0, x - 0.5); }), "one-sided: nothing below 0."));
  EXPECT_TRUE(starts(words(SignalKind::kPosition, -1, 1, [](double x) { return std::min(0.0, x + 0.5); }), "one-sided: nothing above -0."));
  EXPECT_TRUE(starts(words(SignalKind::kPosition, -1, 1, [](double x) { return std::sin(12.0 * x); }), "periodic"));
  EXPECT_TRUE(starts(words(SignalKind::kVelocity, -1, 1, [](double x) { return std::tanh(6.0 * x); }), "odd, saturating"));
  EXPECT_TRUE(starts(words(SignalKind::kVelocity, -1, 1, [](double x) { return x * x; }), "even"));
  EXPECT_TRUE(starts(words(SignalKind::kTorque, -1, 1, [](double x) { return x > 0 ? std::max(0.0, x - 0.4) : std::min(0.0, x + 0.4); }), "dead zone"));
  EXPECT_TRUE(starts(words(SignalKind::kPosition, -1, 1, [](double x) { return 2.0 * x; }), "a straight line"));
  EXPECT_TRUE(starts(words(SignalKind::kHistory, -1, 1, [](double x) { return x; }), "with a memory"));
}

TEST(Tables, ReproduceTheCurve) {
  const Model arm = read_model("planar-2r");
  const UnnamedShape shape = shape_along(-0.5, 1.1, [](double x) { return 2.0 * x + 0.3; });
  const std::vector<EffectTerm> terms = tables_of(arm, {0}, shape, {signal(SignalKind::kPosition, -0.5, 1.1)});
  ASSERT_EQ(terms.size(), 1u);
  BoundEffect effect(arm, terms[0]);
  ASSERT_TRUE(effect.has_values());
  AxisSample x;
  for (x.s = -0.5; x.s < 1.1; x.s += 0.1) EXPECT_NEAR(effect.force(x), 2.0 * (x.s - 0.3), 1e-9);
  EXPECT_TRUE(tables_of(arm, {0}, shape, {signal(SignalKind::kTime, 0, 1)}).empty());
}

// Waves of all joints that repeat after 10 s, for 20 s at 200 Hz.
MotionSamples repeated_waves(int joints, double size) {
  const Eigen::Index rows = 4001;
  MotionSamples m{VectorXd::LinSpaced(rows, 0.0, 20.0), MatrixXd::Zero(rows, joints), MatrixXd::Zero(rows, joints),
                  MatrixXd::Zero(rows, joints)};
  for (int i = 0; i < joints; ++i) {
    for (const int harmonic : {1 + i, 4 + i}) {
      const double w = 2.0 * M_PI * harmonic / 10.0;
      const Eigen::ArrayXd angle = w * m.time.array() + 0.3 * i + harmonic;
      m.q.col(i).array() += size * angle.sin();
      m.dq.col(i).array() += size * w * angle.cos();
      m.ddq.col(i).array() -= size * w * w * angle.sin();
    }
  }
  return m;
}

// Four recordings of the textbook's SCARA, other motions and noise in each, the last one held out.
Diagnosis scara_with(const std::function<void(Recording&, unsigned seed)>& change,
                     UnnamedForces unnamed = UnnamedForces::kReported,
                     const std::function<MotionSamples(int, double)>& motion = waves) {
  const Model scara = read_model("scara");
  std::vector<Recording> recordings;
  for (unsigned k = 1; k <= 4; ++k) {
    SimulationOptions options;
    options.noise = sensor_noise("low");
    options.seed = k;
    const SimulatedRecording s = simulate_recording(scara, motion(scara.joints(), 0.08 + 0.01 * k), options);
    Recording r = recording_of(s);
    change(r, k);
    recordings.push_back(std::move(r));
  }
  DiagnosisOptions options;
  options.unnamed = unnamed;
  options.identification.threads = 1;
  return diagnose(scara, {recordings[0], recordings[1], recordings[2]}, recordings[3], options);
}

// A sliding quill with a ripple in one direction of its motion: sizes are in newtons.
TEST(Unnamed, SizesHaveTheUnitOfTheJoint) {
  const Diagnosis d = scara_with([](Recording& r, unsigned) {
    for (int row = 0; row < r.rows(); ++row) {
      if (r.q(row, 2) * r.dq(row, 2) > 0.01) r.tau(row, 2) += 5.0 * std::sin(60.0 * r.q(row, 2));
    }
  });
  const auto curve = std::find_if(d.findings.begin(), d.findings.end(), [](const Finding& f) { return f.shape.has_value(); });
  ASSERT_NE(curve, d.findings.end()) << d.report();
  EXPECT_EQ(curve->joint, JointIndex{2});
  EXPECT_EQ(curve->unit, "N");
  EXPECT_NE(curve->phrase.find(" N from its lowest"), std::string::npos) << curve->phrase;
}

// The square of another joint's torque is no signal of a table: the curve stays out of the model, and a remark says so.
TEST(Unnamed, ACurveThatIsNotKeptHasAReason) {
  const auto squared = [](Recording& r, unsigned) { r.tau.col(0).array() += 0.02 * r.tau.col(1).array().square(); };
  const auto remarks = [](const Diagnosis& d) {
    return std::count_if(d.remarks.begin(), d.remarks.end(), [](const std::string& remark) {
      return remark.find("Not in the model: the curve of joint 1 over tau2: a table holds signals of") == 0;
    });
  };
  const Diagnosis kept = scara_with(squared, UnnamedForces::kKept);
  EXPECT_EQ(remarks(kept), 1) << kept.report();
  EXPECT_EQ(remarks(scara_with(squared)), 0);
}

TEST(Unnamed, ADeadZoneIsNotNamedAsAConstantFactor) {
  const Diagnosis d = scara_with([](Recording& r, unsigned) {
    for (double& t : r.tau.col(1)) t = std::copysign(std::max(0.0, std::abs(t) - 1.1), t);  // of 1.5 N m
  });
  bool curve = false;
  for (const Finding& f : d.findings) {
    if (!f.joint || f.joint->value != 1) continue;
    curve = curve || f.shape;
    if (effect_of(f.cause) == "torque_gain") {
      EXPECT_NE(f.phrase.find("no constant proportion"), std::string::npos) << d.report();
    }
  }
  EXPECT_TRUE(curve) << d.report();
}

// A spring explains most of the error; friction that depends on another joint is in no dictionary.
TEST(Unnamed, AJointWithACurveIsNamedIfNamesExplainMost) {
  for (const double spring : {0.0, 12.0}) {
    const Diagnosis d = scara_with([spring](Recording& r, unsigned) {
      for (int k = 0; k < r.rows(); ++k)
        r.tau(k, 0) += spring * r.q(k, 0) + 0.4 * std::sin(2.0 * r.q(k, 1)) * (r.dq(k, 0) > 0.0 ? 1.0 : -1.0);
    });
    const JointVerdict& v = d.joints.at(0);
    EXPECT_LT(v.left, v.extended) << d.report();  // there is a curve
    EXPECT_EQ(v.state, spring > 0.0 ? JointState::kNamed : JointState::kUnnamed) << d.report();
    EXPECT_EQ(d.report().find("named in part") != std::string::npos, spring > 0.0) << d.report();
  }
}

// A spring and a larger gain are added half-way through each recording, so that repeats differ.
TEST(Unnamed, AChangeBetweenRepeatsIsNoNoiseFloor) {
  const auto half_way = [](const std::function<double(const Recording&, int)>& change) {
    return scara_with(
        [&change](Recording& r, unsigned) {
          for (int k = r.rows() / 2; k < r.rows(); ++k) r.tau(k, 0) += change(r, k);
        },
        UnnamedForces::kReported, repeated_waves);
  };
  const Diagnosis spring = half_way([](const Recording& r, int k) { return 4.0 * r.q(k, 0); });
  const Diagnosis gain = half_way([](const Recording& r, int k) { return 0.4 * r.tau(k, 0); });
  for (const Diagnosis* d : {&spring, &gain}) {
    const JointVerdict& v = d->joints.at(0);
    ASSERT_EQ(d->baseline.noise_floor.size(), 4) << d->report();
    ASSERT_GT(d->baseline.noise_floor[0], 0.05) << d->report();
    EXPECT_LT(v.floor, 0.7 * d->baseline.noise_floor[0]) << d->report();
    // The mean of the spring is half of it; the rest, and the gain, depend on time.
    EXPECT_EQ(v.state, d == &spring ? JointState::kNamed : JointState::kUnnamed) << d->report();
    EXPECT_TRUE(std::any_of(d->findings.begin(), d->findings.end(), [](const Finding& f) {
      return f.shape && f.joint == JointIndex{0} && f.explains > 0.2 &&
             std::count(f.shape->signals.begin(), f.shape->signals.end(), "t") > 0;
    })) << d->report();
  }
}

// No signal predicts the error by quantisation.
TEST(Unnamed, TheVerdictGivesCoarseStepsOfATorqueAsTheReason) {
  const Diagnosis d = scara_with(
      [](Recording& r, unsigned seed) {
        const double step = (r.tau.col(1).maxCoeff() - r.tau.col(1).minCoeff()) / (3.1 + 1.3 * seed);
        for (double& t : r.tau.col(1)) t = step * std::round(t / step);
      },
      UnnamedForces::kReported, repeated_waves);
  const JointVerdict& v = d.joints.at(1);
  EXPECT_EQ(v.state, JointState::kCannotTell) << d.report();
  EXPECT_EQ(v.why.find("its torque is recorded in steps of "), 0u) << v.why;
  EXPECT_NE(v.why.find(" N m; "), std::string::npos) << v.why;
}

// A vibration of the shoulder, with another phase in each recording.
TEST(Unnamed, AJointWithAVibrationIsNotAtItsFloor) {
  const auto shaken = [](double frequency) {
    return scara_with([frequency](Recording& r, unsigned seed) {
      r.tau.col(0).array() += 0.5 * (2.0 * M_PI * frequency * r.time.array() + 1.7 * seed).sin();
    });
  };
  const JointVerdict v = shaken(1.43).joints.at(0);
  EXPECT_EQ(v.state, JointState::kCannotTell);
  EXPECT_NE(v.why.find("a vibration of 1.43 Hz and 0."), std::string::npos) << v.why;
  EXPECT_GT(v.removable, 0.5 * v.held_out);
  const Diagnosis still = scara_with([](Recording&, unsigned) {});
  for (const JointVerdict& one : still.joints) EXPECT_EQ(one.state, JointState::kAtFloor) << still.report();
}

// The motion of a joint contains the same frequency.
TEST(Unnamed, AFrequencyOfTheMotionIsNoVibration) {
  const auto seen = [](double of_motion) {
    Identification id;
    for (int k = 0; k < 3; ++k) {
      RecordingError r;
      PredictionSeries& x = r.series;
      x.q.resize(1);
      x.dq.resize(1);
      x.measured.resize(1);
      x.modelled.resize(1);
      for (int row = 0; row < 1000; ++row) {
        const double t = 0.02 * row;
        x.time.push_back(t);
        x.q[0].push_back(std::sin(2.0 * M_PI * of_motion * t));
        x.dq[0].push_back(2.0 * M_PI * of_motion * std::cos(2.0 * M_PI * of_motion * t));
        x.modelled[0].push_back(3.0 * x.q[0].back());
        x.measured[0].push_back(x.modelled[0].back() + std::sin(2.0 * M_PI * 1.3 * t + k));
      }
      (k < 2 ? id.train : id.test).push_back(std::move(r));
    }
    return vibration_of(id, 0, Thresholds{});
  };
  ASSERT_TRUE(seen(0.4).has_value());
  EXPECT_NEAR(seen(0.4)->frequency, 1.3, 0.01);
  EXPECT_NEAR(seen(0.4)->amplitude, 1.0, 0.05);
  EXPECT_FALSE(seen(1.3).has_value());
}

// The same arm in which joints 1 and 3 follow one sine, 2 another one.
TEST(CorrelatedJoints, FindsCollinearPositions) {
  MatrixXd q(500, 4);
  for (int k = 0; k < 500; ++k) {
    const double t = 0.02 * k;
    q.row(k) << std::sin(t), std::sin(1.3 * t), 0.2 - 0.5 * std::sin(t), 0.0;
  }
  const auto groups = correlated_joints(q);
  ASSERT_EQ(groups.size(), 1u);
  EXPECT_EQ(groups[0], (std::vector<JointIndex>{{0}, {2}}));
  EXPECT_EQ(numbers_from_one({{0}, {2}, {3}}), "1, 3 and 4");
}

}  // namespace
}  // namespace veridyn
