#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/two_joint_arm.hpp"
#include "veridyn/files/model_file.hpp"

// Diagnoses from recordings to report.

namespace veridyn {
namespace {

class WholeDiagnosis : public TwoJointArm {
 protected:
  // The last of five recordings is held out.
  Diagnosis diagnosed(const Model& robot, const std::vector<std::string>& hidden, const std::vector<std::string>& effects,
                      const std::function<void(Recording&, unsigned)>& change = {}) const {
    std::vector<Recording> all;
    for (unsigned k = 1; k <= 5; ++k) {
      all.push_back(read_recording(record(k, hidden)));
      all.back().source = "recording " + std::to_string(k);
      if (change) change(all.back(), k);
    }
    DiagnosisOptions options;
    options.identification.threads = 1;
    options.effects = effects;
    return diagnose(robot, {all[0], all[1], all[2], all[3]}, all[4], options);
  }
};

TEST_F(WholeDiagnosis, RecordingsThatGiveNoModelGiveAReason) {
  const Diagnosis d = diagnosed(read_model("planar-2r"), {}, {}, [](Recording& r, unsigned) { r = rows_of(r, 0, 50); });
  EXPECT_FALSE(d.baseline.model.has_value());
  EXPECT_NE(d.baseline.reason.find("no usable samples"), std::string::npos) << d.baseline.reason;
  EXPECT_EQ(d.report(), d.baseline.report());
  EXPECT_TRUE(d.findings.empty());
  EXPECT_TRUE(d.joints.empty());
}

// The push is the first finding.
TEST_F(WholeDiagnosis, APushDoesNotChangeTheEstimateOfASpring) {
  const std::vector<std::string> hidden = {"joint_spring:elbow:stiffness=4"}, effects = {"joint_spring", "external_contact"};
  const auto spring_of = [](const Diagnosis& d) {
    const auto found = std::find_if(d.findings.begin(), d.findings.end(), [](const Finding& f) { return effect_of(f.cause) == "joint_spring"; });
    EXPECT_NE(found, d.findings.end()) << d.report();
    return found == d.findings.end() ? 0.0 : found->parameters[0].value;
  };
  const Diagnosis alone = diagnosed(read_model("planar-2r"), hidden, effects);
  const Diagnosis pushed = diagnosed(read_model("planar-2r"), hidden, effects, [](Recording& r, unsigned k) {
    for (int row = 0; k == 2 && row < r.rows(); ++row) {
      if (r.time[row] > 5.0 && r.time[row] < 6.0) r.tau(row, 0) += 15.0;
    }
  });
  EXPECT_EQ(alone.findings.size(), 1U) << alone.report();
  ASSERT_EQ(pushed.findings.size(), 2U) << pushed.report();
  EXPECT_TRUE(std::holds_alternative<ExternalContact>(pushed.findings[0].cause));
  EXPECT_EQ(pushed.findings[0].source, "recording 2");
  EXPECT_NEAR(spring_of(pushed), spring_of(alone), 0.02);
  EXPECT_LT(pushed.extended.test_error.relative.maxCoeff(), 1.1 * alone.extended.test_error.relative.maxCoeff());
}

// The same torque in one period of a motion, and at one phase of all of them.
TEST_F(WholeDiagnosis, AMomentThatComesBackWithTheMotionIsNoPush) {
  constexpr double kTurn = 5.0;
  const auto pushes = [&](bool in_every_period) {
    std::vector<Recording> all;
    for (unsigned k = 1; k <= 3; ++k) {
      MotionSamples m = motion(k);
      m.q.setZero();
      m.dq.setZero();
      m.ddq.setZero();
      for (int wave = 1; wave <= 4; ++wave) {
        const double w = 2.0 * M_PI * wave / kTurn;
        for (int i = 0; i < 2; ++i) {
          const Eigen::ArrayXd angle = w * m.time.array() + 1.7 * (i + 1) * wave + k;
          m.q.col(i).array() += 0.5 / wave * angle.sin();
          m.dq.col(i).array() += 0.5 / wave * w * angle.cos();
          m.ddq.col(i).array() -= 0.5 / wave * w * w * angle.sin();
        }
      }
      SimulationOptions options;
      options.noise = sensor_noise("low");
      options.seed = k;
      all.push_back(recording_of(simulate_recording(truth_, m, options)));
      all.back().source = "recording " + std::to_string(k);
      Recording& r = all.back();
      for (int row = 0; k == 2 && row < r.rows(); ++row) {
        const double since = r.time[row] - 6.0, phase = in_every_period ? std::fmod(r.time[row] + kTurn - 1.0, kTurn) : since;
        if (phase > 0.0 && phase < 0.7) r.tau(row, 0) += 15.0;
      }
    }
    DiagnosisOptions options;
    options.identification.threads = 1;
    options.effects = {"joint_spring", "external_contact"};
    const Diagnosis d = diagnose(read_model("planar-2r"), {all[0], all[1]}, all[2], options);
    return std::count_if(d.findings.begin(), d.findings.end(), [](const Finding& f) { return std::holds_alternative<ExternalContact>(f.cause); });
  };
  EXPECT_EQ(pushes(false), 1);
  EXPECT_EQ(pushes(true), 0);
}

// Where a joint turns back slowly its friction may have any size up to its level, and the model has all of it. More is a push.
TEST_F(WholeDiagnosis, DryFrictionAtASlowReversalIsNoPush) {
  constexpr double level = 4.0;
  ModelDescription strong = truth_.description();
  for (EffectTerm& term : strong.effects)
    if (term.effect == "coulomb_friction" && term.axis.coefficients[0] == 1.0) term.values["level"] = level;
  truth_ = Model(strong);
  const auto pushes = [&](double size) {
    std::vector<Recording> all;
    for (unsigned k = 1; k <= 3; ++k) {
      MotionSamples m = motion(k);
      // The speed cos(x) + cos(3 x) / 3 is flat at its zeros.
      const double w = 0.4 + 0.02 * k;
      const Eigen::ArrayXd x = w * m.time.array();
      m.q.col(0) = x.sin() + (3.0 * x).sin() / 9.0;
      m.dq.col(0) = w * (x.cos() + (3.0 * x).cos() / 3.0);
      m.ddq.col(0) = -w * w * (x.sin() + (3.0 * x).sin());
      SimulationOptions options;
      options.noise = sensor_noise("low");
      options.seed = k;
      all.push_back(recording_of(simulate_recording(truth_, m, options)));
      Recording& r = all.back();
      r.source = "recording " + std::to_string(k);
      const double reversal = 0.5 * M_PI / w;
      for (int row = 0; k == 2 && row < r.rows(); ++row)
        if (r.time[row] > reversal && r.time[row] < reversal + 0.65) r.tau(row, 0) += size * level;
    }
    DiagnosisOptions options;
    options.identification.threads = 1;
    options.effects = {"joint_spring", "external_contact"};
    const Diagnosis d = diagnose(truth_, {all[0], all[1]}, all[2], options);
    return std::count_if(d.findings.begin(), d.findings.end(), [](const Finding& f) { return std::holds_alternative<ExternalContact>(f.cause); });
  };
  EXPECT_EQ(pushes(0.8), 0);
  EXPECT_EQ(pushes(3.0), 1);
}

// A chirp in two of three recordings, each of which repeats its motion: it does not come back with the motion.
TEST_F(WholeDiagnosis, WhatIsInOneRecordingDoesNotComeBackWithTheMotion) {
  constexpr double kTurn = 2.5;
  const auto why = [&](bool in_all) {
    std::vector<Recording> all;
    for (unsigned k = 1; k <= 4; ++k) {
      MotionSamples m = motion(k);
      m.q.setZero();
      m.dq.setZero();
      m.ddq.setZero();
      for (int wave = 1; wave <= 4; ++wave) {
        const double w = 2.0 * M_PI * wave / kTurn;
        for (int i = 0; i < 2; ++i) {
          const Eigen::ArrayXd angle = w * m.time.array() + 1.7 * (i + 1) * wave + k;
          m.q.col(i).array() += 0.5 / wave * angle.sin();
          m.dq.col(i).array() += 0.5 / wave * w * angle.cos();
          m.ddq.col(i).array() -= 0.5 / wave * w * w * angle.sin();
        }
      }
      SimulationOptions options;
      options.noise = sensor_noise("low");
      options.seed = k;
      all.push_back(recording_of(simulate_recording(truth_, m, options)));
      all.back().source = "recording " + std::to_string(k);
      Recording& r = all.back();
      for (int row = 0; (in_all || k == 2 || k == 4) && row < r.rows(); ++row) {
        const double phase = std::fmod(r.time[row], kTurn);
        r.tau(row, 1) += std::sin((8.0 + 3.0 * k) * phase + 4.0 * phase * phase);
      }
    }
    DiagnosisOptions options;
    options.identification.threads = 1;
    const Diagnosis d = diagnose(truth_, {all[0], all[1], all[2]}, all[3], options);
    return d.joints[1].why;
  };
  EXPECT_EQ(why(true).find("left over in recording"), std::string::npos) << why(true);
  EXPECT_EQ(why(false).find("comes back"), std::string::npos) << why(false);
  EXPECT_NE(why(false).find("left over in recording"), std::string::npos) << why(false);
}

// The shoulder has a force of position that no tested cause describes, in the held-out recording with either sign.
TEST_F(WholeDiagnosis, AJointWithACauseThatWasNotTestedIsNotAtItsFloor) {
  for (const double sign : {1.0, -1.0}) {
    const Diagnosis d = diagnosed(read_model("planar-2r"), {}, {"viscous_friction"}, [sign](Recording& r, unsigned k) {
      r.tau.col(0).array() += (k < 5 ? 4.0 : 4.0 * sign) * (3.0 * r.q.col(0).array()).sin();
    });
    const JointVerdict& v = d.joints.at(0);
    ASSERT_EQ(v.state, JointState::kCannotTell) << d.report();
    EXPECT_EQ(d.joints.at(1).state, JointState::kAtFloor) << d.report();
    EXPECT_EQ(v.why.find("not all causes were asked about; signals of the motion predict "), 0U) << v.why;
    EXPECT_EQ(v.why.find("predict 0 %") != std::string::npos, sign < 0.0) << v.why;
    EXPECT_EQ(v.floor < 0.2 * v.held_out, sign > 0.0);
    EXPECT_NE(d.verdict(), "none");
  }
}

// The robot file has no friction.
TEST_F(WholeDiagnosis, AddedFrictionIsReportedInATableAndIsNoFinding) {
  ModelDescription bare = without_effects(read_model("planar-2r")).description();
  bare.values = RobotValues::kPrior;
  const Diagnosis d = diagnosed(Model(std::move(bare)), {}, {"joint_spring"});
  ASSERT_FALSE(d.friction_remark.empty()) << d.report();
  EXPECT_TRUE(d.findings.empty()) << d.report();
  EXPECT_FALSE(d.friction.empty());
  EXPECT_NE(d.report().find(d.friction_remark + " Found: table below."), std::string::npos) << d.report();
  EXPECT_NE(d.report().find("\nfriction, offset and rotor inertia that were found"), std::string::npos) << d.report();
  EXPECT_NE(d.report().find("  shoulder "), std::string::npos);
}

}  // namespace
}  // namespace veridyn
