#include "veridyn/diagnosis/diagnosis.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <random>

#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/plausible_model.hpp"

namespace veridyn {
namespace {

constexpr double kStiffness = 1.5;   // [N m/rad] of a cable on the pitch joint
constexpr double kFriction = 0.05;   // [N m], [N] on the side that a joint came from
constexpr double kNoise = 0.01;

Recording hanging_poses(unsigned seed, double stiffness, bool pitch_moves = true) {
  const Model truth = plausible_model(read_model("psm-3dof"), 3).arm;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> share(-0.9, 0.9);
  std::normal_distribution<double> error(0.0, kNoise);
  RigidBodyDynamics bodies(truth, *truth.inertial_values());
  Recording out;
  out.poses = true;
  out.time = VectorXd::LinSpaced(80, 0.0, 79.0);
  out.source = "poses" + std::to_string(seed);
  out.q.resize(80, 3);
  out.tau.resize(80, 3);
  out.dq.setZero(80, 3);
  VectorXd g(3);
  for (Eigen::Index k = 0; k < out.q.rows(); ++k) {
    const Eigen::Vector3d q(share(random), pitch_moves ? 0.6 * share(random) : 0.2, 0.12 + 0.06 * share(random));
    bodies.gravity_torques(q, g);
    g[1] += stiffness * std::abs(q[1]);
    out.q.row(k) = q.transpose();
    for (int i = 0; i < 3; ++i)
      out.tau(k, i) = g[i] + (random() % 2 == 0 ? kFriction : -kFriction) + error(random);
  }
  return out;
}

Diagnosis of_poses(double stiffness, bool pitch_moves = true) {
  return diagnose(read_model("psm-3dof"),
                          {hanging_poses(1, stiffness, pitch_moves), hanging_poses(2, stiffness, pitch_moves)},
                          {hanging_poses(3, stiffness, pitch_moves)});
}

// The cable pulls towards the middle from both sides.
TEST(DiagnosisAtRest, NamesACableOnItsJoint) {
  const Diagnosis d = of_poses(kStiffness);
  ASSERT_FALSE(d.findings.empty());
  EXPECT_EQ(effect_of(d.findings[0].cause), "position_force");
  ASSERT_TRUE(d.findings[0].joint.has_value());
  EXPECT_EQ(d.findings[0].joint->value, 1);
  EXPECT_EQ(d.joints[1].state, JointState::kNamed);
  EXPECT_LT(d.extended.test_error.relative[1], 0.5 * d.baseline.test_error.relative[1]);
}

TEST(DiagnosisAtRest, NamesNothingIfThereIsOnlyGravityAndFriction) {
  const Diagnosis d = of_poses(0.0);
  EXPECT_TRUE(d.findings.empty()) << d.report();
  for (const JointVerdict& v : d.joints) EXPECT_EQ(v.state, JointState::kAtFloor) << d.report();
}

TEST(DiagnosisAtRest, TestsNothingOnAJointThatDoesNotMove) {
  const Diagnosis all = of_poses(0.0);
  const Diagnosis some = of_poses(kStiffness, false);
  ASSERT_TRUE(some.baseline.model.has_value()) << some.baseline.reason;
  EXPECT_LT(some.hypotheses, all.hypotheses);
  for (const Finding& f : some.findings) EXPECT_NE(f.joint->value, 1) << some.report();
}

// The verdict says that other causes were not tested.
TEST(DiagnosisAtRest, TestsOnlyTheGivenCauses) {
  const std::vector<Recording> train = {hanging_poses(1, kStiffness), hanging_poses(2, kStiffness)};
  const auto asked = [&train](const std::string& cause) {
    DiagnosisOptions options;
    options.effects = {cause};
    return diagnose(read_model("psm-3dof"), train, {hanging_poses(3, kStiffness)}, options);
  };
  EXPECT_EQ(asked("position_force:yaw").hypotheses, 1);
  const Diagnosis pitch = asked("position_force:2");
  EXPECT_EQ(pitch.hypotheses, 1);
  ASSERT_EQ(pitch.findings.size(), 1U) << pitch.report();
  EXPECT_EQ(pitch.findings[0].joint, JointIndex{1});
  const Diagnosis friction = asked("stribeck_friction");
  EXPECT_EQ(friction.hypotheses, 0);
  EXPECT_EQ(friction.joints.at(1).state, JointState::kCannotTell) << friction.report();
  EXPECT_NE(friction.joints.at(1).why.find("not all causes were asked about"), std::string::npos) << friction.joints.at(1).why;
  EXPECT_THROW(asked("position_farce"), InvalidInput);
}

TEST(DiagnosisAtRest, CannotTellAboutAJointWithoutAHeldOutError) {
  const std::vector<Recording> train = {hanging_poses(1, 0.0), hanging_poses(2, 0.0)};
  const Diagnosis nothing_held_out = diagnose(read_model("psm-3dof"), train, {});
  ASSERT_EQ(nothing_held_out.joints.size(), 3U);
  EXPECT_EQ(nothing_held_out.verdict(), "no cause was found; joints without a held-out error: 1, 2, 3");
  Recording test = hanging_poses(3, 0.0);
  test.tau.col(2).setZero();
  const Diagnosis without_torque = diagnose(read_model("psm-3dof"), train, {test});
  EXPECT_EQ(without_torque.verdict(), "no cause was found; joints without a held-out error: 3") << without_torque.report();
  EXPECT_NE(without_torque.report().find("its torque is zero throughout"), std::string::npos) << without_torque.report();
}


// A change of the arm or of its sensors since the MODEL was identified from poses of the sound arm.
struct ChangedArm {
  Model arm;
  VectorXd shown = VectorXd::Zero(6);   // [rad] error of every encoder
  VectorXd scaled = VectorXd::Ones(6);  // factor of every recorded torque
};

Recording poses_of(const ChangedArm& truth, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> share(-1.2, 1.2);
  std::normal_distribution<double> error(0.0, 0.1);
  RigidBodyDynamics bodies(truth.arm, *truth.arm.inertial_values());
  Recording out;
  out.source = "poses" + std::to_string(seed);
  out.poses = true;
  out.time = VectorXd::LinSpaced(60, 0.0, 59.0);
  out.q = out.tau = out.dq = MatrixXd::Zero(60, 6);
  VectorXd q(6), g(6);
  for (int k = 0; k < 60; ++k) {
    for (double& one : q) one = share(random);
    bodies.gravity_torques(q, g);
    for (int i = 0; i < 6; ++i) {
      out.dq(k, i) = random() % 2 == 0 ? 1.0 : -1.0;
      out.tau(k, i) = truth.scaled[i] * (g[i] + out.dq(k, i) + error(random));
    }
    out.q.row(k) = (q + truth.shown).transpose();
  }
  return out;
}

class PosesOfAChangedArm : public testing::Test {
 protected:
  PosesOfAChangedArm() : sound_{plausible_model(read_model("ur10e"), 3).arm} {}

  // @param first  seed of the first of five recordings.
  Diagnosis diagnosis_of(const ChangedArm& changed, unsigned first = 1) const {
    const Identification model = identify(read_model("ur10e"), {poses_of(sound_, first), poses_of(sound_, first + 1)});
    return diagnose(*model.model, {poses_of(changed, first + 2), poses_of(changed, first + 3)}, {poses_of(changed, first + 4)});
  }

  // The only finding.
  static Finding only_one(const Diagnosis& d, const std::string& effect) {
    EXPECT_EQ(d.summary.main, 1) << d.report();
    if (d.findings.empty()) return {};
    EXPECT_EQ(effect_of(d.findings[0].cause), effect) << d.report();
    return d.findings[0];
  }

  ChangedArm sound_;
};

TEST_F(PosesOfAChangedArm, AtMostOneOfEightUnchangedArmsHasAFinding) {
  int found = 0;
  for (unsigned first = 1; first <= 71; first += 10) found += diagnosis_of(sound_, first).findings.empty() ? 0 : 1;
  EXPECT_LE(found, 1);
}

TEST_F(PosesOfAChangedArm, ALoadIsFoundWithItsMass) {
  ModelDescription loaded = sound_.arm.description();
  Frame frame;
  frame.name = "weight";
  frame.parent = FrameIndex{static_cast<int>(loaded.frames.size()) - 1};
  frame.variable.coefficients = VectorXd::Zero(6);
  frame.body = Body{};
  frame.body->phi = InertialParameters::Zero();
  (*frame.body->phi)[0] = 1.0;
  loaded.frames.push_back(frame);
  const Finding load = only_one(diagnosis_of({Model(loaded)}), AddedLoad::kName);
  ASSERT_FALSE(load.parameters.empty());
  EXPECT_NEAR(load.parameters[0].value, 1.0, 0.03);
}

TEST_F(PosesOfAChangedArm, ALeaningBaseIsFoundWithItsAngle) {
  ModelDescription leaning = sound_.arm.description();
  leaning.gravity = Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitX()) * leaning.gravity;
  const Finding lean = only_one(diagnosis_of({Model(leaning)}), "gravity_tilt");
  ASSERT_FALSE(lean.parameters.empty());
  EXPECT_NEAR(std::abs(lean.parameters[0].value), 0.05, 0.002);
}

TEST_F(PosesOfAChangedArm, AWrongEncoderZeroIsFoundOnItsJoint) {
  ChangedArm changed = sound_;
  changed.shown[1] = 0.06;
  const Finding zero = only_one(diagnosis_of(changed), "encoder_offset");
  ASSERT_TRUE(zero.joint.has_value());
  EXPECT_EQ(zero.joint->value, 1);
  EXPECT_NEAR(zero.parameters[0].value, 0.06, 0.002);
}

TEST_F(PosesOfAChangedArm, AWrongTorqueScaleIsFoundOnItsJoint) {
  ChangedArm changed = sound_;
  changed.scaled[1] = 1.2;
  const Finding gain = only_one(diagnosis_of(changed), "torque_gain");
  ASSERT_TRUE(gain.joint.has_value());
  EXPECT_EQ(gain.joint->value, 1);
}

}  // namespace
}  // namespace veridyn
