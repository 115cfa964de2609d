#include "hide_and_seek/generator.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "support/near.hpp"
#include "veridyn/effects/effect.hpp"

namespace veridyn::seek {
namespace {

double rms(const VectorXd& x) {
  return std::sqrt(x.squaredNorm() / static_cast<double>(x.size()));
}

Bench scara() {
  return make_bench("pick-scara", 7);
}

TEST(Motion, VelocityAndAccelerationAreDerivatives) {
  const Motion motion(scara().robot, 7, 3);
  constexpr double h = 1e-4;
  for (const double t : {0.3, 0.9, 5.0, motion.duration() - 0.4}) {
    const State a = motion.at(t - h);
    const State s = motion.at(t);
    const State b = motion.at(t + h);
    EXPECT_TRUE(near(s.dq, (b.q - a.q) / (2.0 * h), 1e-6));
    EXPECT_TRUE(near(s.ddq, (b.dq - a.dq) / (2.0 * h), 1e-5));
  }
}

TEST(Motion, StartsAndEndsAtRest) {
  for (const std::string& arm : bench_arms()) {
    const Motion motion(make_bench(arm, 7).robot, 7, 1);
    for (const double t : {0.0, motion.duration()}) {
      EXPECT_LT(motion.at(t).dq.norm(), 1e-9) << arm;
      EXPECT_LT(motion.at(t).ddq.norm(), 1e-8) << arm;
    }
  }
}

TEST(Motion, KeepsToTheLimitsAndRepeatsButForTheControllersError) {
  for (const std::string& arm : bench_arms()) {
    const Bench bench = make_bench(arm, 8);
    const Motion motion(bench.robot, 8, 2);
    EXPECT_GE(motion.duration(), 20.0);
    EXPECT_LE(motion.duration(), 30.0);
    const Motion::Rows rows = motion.sampled(kRate);
    for (int i = 0; i < bench.arm.joints; ++i) {
      const Limits& limits = bench.robot.coordinates()[i].limits;
      EXPECT_GE(rows.q.col(i).minCoeff(), limits.lower) << arm;
      EXPECT_LE(rows.q.col(i).maxCoeff(), limits.upper) << arm;
      EXPECT_LE(rows.dq.col(i).cwiseAbs().maxCoeff(), 1.02 * limits.velocity) << arm;
    }
    const VectorXd again = motion.at(6.0 + 0.5 * motion.duration()).q - motion.at(6.0).q;
    EXPECT_LT(again.cwiseAbs().maxCoeff(), 0.03) << arm;
    EXPECT_GT(again.norm(), 0.0) << arm;
  }
}

// The lag-1 covariance of a first-order process is its variance times exp(-2 pi f dt); white noise
// has none. 200,000 samples with 100 in a correlation time: 2 % of the rms.
TEST(Sensors, HalfOfTheTorqueNoiseIsColoured) {
  Draw draw(3, "test");
  const VectorXd noise = torque_noise(2.0, 200000, draw);
  EXPECT_NEAR(rms(noise), 2.0, 0.04);
  const Eigen::Index n = noise.size() - 1;
  const double lag = noise.head(n).dot(noise.tail(n)) / static_cast<double>(n);
  EXPECT_NEAR(lag, 0.5 * 4.0 * std::exp(-2.0 * M_PI * 2.0 / kRate), 0.08);
}

TEST(Causes, ADelayOfWholeRowsIsAShiftAndOneOfAFractionFollowsASine) {
  const VectorXd time = VectorXd::LinSpaced(2001, 0.0, 10.0);
  const VectorXd wave = (3.0 * time.array()).sin();
  EXPECT_TRUE(near(delayed(wave, 5e-3, 0.01).tail(1900), wave.segment(99, 1900), 1e-12));
  const VectorXd late = (3.0 * (time.array() - 0.0037)).sin();
  EXPECT_TRUE(near(delayed(wave, 5e-3, 0.0037).segment(10, 1900), late.segment(10, 1900), 1e-6));
}

TEST(Causes, ATiltTurnsTheBaseUnderGravity) {
  Cause tilt{"gravity_tilt", -1, -1, "", "", {{"roll", 0.2}, {"pitch", -0.3}}};
  const LagrangeArm arm = changed(scara().arm, {tilt});
  const Eigen::Matrix3d R =
      (Eigen::AngleAxisd(-0.3, Vector3d::UnitY()) * Eigen::AngleAxisd(0.2, Vector3d::UnitX()))
          .toRotationMatrix();
  EXPECT_TRUE(near(R * arm.gravity, Vector3d(0.0, 0.0, -9.81), 1e-12));
}

// The library's columns of the same effect with the same constants, on the same motion.
MatrixXd library_columns(const Bench& bench, const Cause& cause, const Motion::Rows& rows,
                         const VectorXd& load) {
  EffectTerm term;
  term.effect = cause.effect;
  term.axis.coefficients = VectorXd::Unit(bench.arm.joints, cause.joint);
  if (cause.from >= 0) term.from = Axis{VectorXd::Unit(bench.arm.joints, cause.from), 0.0};
  const Effect& effect = find_effect(cause.effect);
  for (const EffectShape& shape : effect.shapes()) {
    const auto found = cause.values.find(shape.name);
    if (found != cause.values.end()) term.values[shape.name] = found->second;
  }
  BoundEffect bound(bench.robot, term);
  MatrixXd out(rows.time.size(), bound.parameter_count());
  for (Eigen::Index r = 0; r < rows.time.size(); ++r) {
    AxisSample x = bound.sample(rows.time[r], rows.q.data() + r, rows.dq.data() + r,
                                rows.ddq.data() + r, rows.q.rows());
    x.load = load[r];
    EffectColumns row{};
    bound.columns(x, row);
    for (int p = 0; p < bound.parameter_count(); ++p) out(r, p) = row[p];
  }
  return out;
}

// Two implementations of one definition. They differ by the sign within a milliradian per second of
// rest, memories at 1 ms against 5 ms, a second derivative that is one row late.
TEST(Causes, HaveTheTorquesOfTheLibrarysEffects) {
  const Bench bench = scara();
  const Motion motion(bench.robot, 9, 1);
  const IdealRecording plain = ideal_recording(bench, {}, motion, 1);
  for (const std::string& effect : all_causes()) {
    const std::vector<std::string> names = linear_parameters(effect);
    if (names.empty() || effect == "position_force") continue;  // any smooth function
    Cause cause{effect, 1, effect == "cable_coupling" ? 0 : -1, "", "", {}};
    Draw draw(9, effect);
    Reach reach{0.0, 30.0, 3.0, 25.0, false};  // gaps and distances of a good part of the way
    draw_shapes(cause, reach, draw);
    cause.values["centre"] = 0.0;
    if (effect == "end_stop") cause.values["reach"] = 0.2;  // 30 rad have no end
    const VectorXd load = plain.rigid.col(1);
    const MatrixXd mine = cause_columns(cause, motion, plain.rows, load);
    const MatrixXd theirs = library_columns(bench, cause, plain.rows, load);
    const std::vector<EffectParameter> parameters = find_effect(effect).parameters();
    for (size_t p = 0; p < names.size(); ++p) {
      for (size_t k = 0; k < parameters.size(); ++k) {
        if (parameters[k].name != names[p]) continue;
        const VectorXd a = mine.col(p);
        const VectorXd b = theirs.col(k);
        EXPECT_LT(rms(a - b), (effect == "transmission_compliance" ? 0.05 : 0.025) * rms(b))
            << effect << " " << names[p];
        EXPECT_GT(rms(b), 0.0) << effect << " " << names[p];
      }
    }
  }
}

TEST(Generator, HidesCausesOfTheRequestedSize) {
  for (const double share : {0.1, 0.03}) {
    const HiddenCase one = hide({"pick-scara", {"quadratic_drag"}, 1, share, Mode::kBare});
    ASSERT_EQ(one.causes.size(), 1U);
    EXPECT_NEAR(one.shares[0], share, 1e-6);
  }
}

TEST(Generator, MarksCausesThatAreNotObservable) {
  EXPECT_LT(hide({"psm-3dof", {}, 1, 0.1, Mode::kBare}).visible.best_gain, 1e-9);
  EXPECT_FALSE(hide({"pick-scara", {"payload"}, 1, 0.1, Mode::kBare}).observable);
  EXPECT_TRUE(hide({"pick-scara", {"payload"}, 1, 0.1, Mode::kChanged}).observable);
}

// The rotor of the first joint cannot be separated from its link and is never chosen.
TEST(Generator, HidesRotorInertiaWhereItIsNoBaseParameter) {
  for (const unsigned seed : {1U, 2U, 3U, 4U}) {
    const HiddenCase one = hide({"bench-6r", {"rotor_inertia"}, seed, 0.1, Mode::kBare});
    ASSERT_TRUE(one.observable);
    EXPECT_GE(one.causes[0].joint, 1) << seed;
  }
}

TEST(Generator, TheSameRequestIsTheSameCaseAndAnotherSeedIsNot) {
  const CaseRequest request{"psm-3dof", {"backlash"}, 3, 0.1, Mode::kBare};
  CaseRequest other = request;
  other.seed = 4;
  const HiddenCase a = hide(request);
  const HiddenCase b = hide(request);
  EXPECT_EQ(a.causes[0].values, b.causes[0].values);
  EXPECT_EQ(a.bench.arm.links[1].moments, b.bench.arm.links[1].moments);
  EXPECT_NE(a.bench.arm.links[1].moments, hide(other).bench.arm.links[1].moments);
}

TEST(Generator, TwoCausesAreOnDifferentJoints) {
  const HiddenCase two = hide({"pallet-4", {"backlash", "quadratic_drag"}, 2, 0.1, Mode::kBare});
  ASSERT_EQ(two.causes.size(), 2U);
  EXPECT_NE(two.causes[0].joint, two.causes[1].joint);
}

}  // namespace
}  // namespace veridyn::seek
