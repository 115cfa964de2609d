#include <gtest/gtest.h>

#include "control/control_support.hpp"
#include "control/static_forces.hpp"
#include "veridyn/control/arm_state.hpp"
#include "veridyn/control/computed_torque.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/kinematics/kinematics.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/simulation/plant.hpp"

namespace veridyn {
namespace {

constexpr double kRounding = 1e-11;

class ArmStateOnEverySampleArm : public OnSampleArm {};
INSTANTIATE_TEST_SUITE_P(Sample, ArmStateOnEverySampleArm, testing::ValuesIn(sample_arm_names()),
                         sample_arm_name);

TEST_P(ArmStateOnEverySampleArm, TipKinematicsEqualThePoseAndJacobianOfTheFrame) {
  const FrameIndex frame{static_cast<int>(arm().frames().size()) - 1};
  TipKinematics tip(arm(), {last_frame(arm())});
  for (const State& s : test_states(joints(), 101)) {
    tip.update(s.q, s.dq);
    const Eigen::Matrix4d T = frame_pose(arm(), s.q, frame).matrix();
    EXPECT_TRUE(near(tip.position(), T.topRightCorner<3, 1>(), kRounding));
    EXPECT_TRUE(near(tip.rotation(), T.topLeftCorner<3, 3>(), kRounding));
    EXPECT_TRUE(near(tip.jacobian(), frame_jacobian(arm(), s.q, frame), kRounding));
    EXPECT_TRUE(near(tip.jacobian_rate(), frame_jacobian_rate(arm(), s.q, s.dq, frame), kRounding));
    EXPECT_TRUE(near(tip.twist(), tip.jacobian() * s.dq, kRounding));
  }
}

// An offset in the frame: position from the pose, Jacobian and rate by central differences of it.
TEST_P(ArmStateOnEverySampleArm, AnOffsetTipMovesAsAPointOfTheFrame) {
  const Eigen::Vector3d offset(0.1, -0.2, 0.3);
  const FrameIndex frame{static_cast<int>(arm().frames().size()) - 1};
  TipKinematics tip(arm(), {last_frame(arm()), offset});
  const State s = test_states(joints(), 102).back();
  tip.update(s.q, s.dq);
  const auto position = [&](const VectorXd& q) -> Eigen::Vector3d {
    const Eigen::Matrix4d T = frame_pose(arm(), q, frame).matrix();
    return T.topRightCorner<3, 1>() + T.topLeftCorner<3, 3>() * offset;
  };
  EXPECT_TRUE(near(tip.position(), position(s.q), kRounding));
  const MatrixXd dJ = tip.jacobian_rate();
  const double h = 1e-5;
  const VectorXd ahead = s.q + h * s.dq;
  const VectorXd behind = s.q - h * s.dq;
  const Eigen::Vector3d v = (position(ahead) - position(behind)) / (2.0 * h);
  EXPECT_TRUE(near(tip.twist().head<3>(), v, 1e-7 * (1.0 + v.norm())));
  tip.update(ahead, s.dq);
  const MatrixXd J_ahead = tip.jacobian();
  tip.update(behind, s.dq);
  EXPECT_TRUE(near(dJ, (J_ahead - tip.jacobian()) / (2.0 * h), 1e-7 * (1.0 + dJ.norm())));
}

TEST_P(ArmStateOnEverySampleArm, MassMatrixAndBiasEqualRigidBodyDynamics) {
  ArmState state(arm(), {last_frame(arm())});
  RigidBodyDynamics dynamics(arm(), phi());
  VectorXd h(joints());
  const VectorXd rest = VectorXd::Zero(joints());
  for (const State& s : test_states(joints(), 103)) {
    state.update(s.q, s.dq);
    dynamics.inverse_dynamics(s.q, s.dq, rest, h);
    EXPECT_TRUE(near(state.mass_matrix(), mass_matrix(arm(), s.q), 1e-10 * (1.0 + h.norm())));
    EXPECT_TRUE(near(state.bias(), h, kRounding * (1.0 + h.norm())));
  }
}

// With rotors, springs and cables in the model, a computed torque gives the plant the acceleration
// that was asked for: the plant reads the same model through code of its own.
TEST_P(ArmStateOnEverySampleArm, ComputedTorqueProducesTheRequestedAcceleration) {
  std::vector<EffectTerm> effects;
  for (int i = 0; i < joints(); ++i) {
    effects.push_back(effect_on(arm(), "rotor_inertia", i, {{"inertia", 0.3 + 0.1 * i}}));
    effects.push_back(effect_on(arm(), "joint_spring", i, {{"stiffness", 2.0 + i}}));
    effects.push_back(effect_on(arm(), "torque_offset", i, {{"offset", 0.5 - i}}));
  }
  const Model full = with_effects(arm(), effects);
  ArmState state(full, {last_frame(full)});
  JointGains gains{VectorXd::Constant(joints(), 25.0), VectorXd::Constant(joints(), 10.0)};
  ComputedTorque control(joints(), gains);
  Plant plant(full);
  JointReference wanted(joints());
  for (const State& s : test_states(joints(), 104)) {
    wanted.q = 0.9 * s.q;
    wanted.dq = 0.5 * s.dq;
    wanted.ddq = s.ddq;
    state.update(s.q, s.dq);
    const VectorXd tau = control.update(state, wanted);
    plant.set_state(s.q, s.dq);
    VectorXd ddq(joints());
    ASSERT_EQ(plant.accelerate(tau, ddq), StepStatus::kOk);
    const VectorXd y = s.ddq - 0.1 * 25.0 * s.q - 0.5 * 10.0 * s.dq;
    EXPECT_TRUE(near(ddq, y, 1e-8 * (1.0 + y.norm())));
  }
}

// What is counted from the start of a recording means nothing to a controller, nor does what was
// measured; everything else is compensated in one place.
TEST(ArmState, LeavesOutExactlyTheEffectsOfRecordingsAndSensors) {
  std::vector<std::string> left_out;
  for (const Effect* e : all_effects()) {
    if (control_part(e->traits()) == ControlPart::kLeftOut) left_out.push_back(e->name());
  }
  const std::vector<std::string> expected{
      "transmission_compliance", "torque_gain", "torque_drift", "time_delay", "gravity_tilt",
      "encoder_offset",          "warm_up",     "base_compliance", "tip_force",
      "torque_crosstalk"};
  EXPECT_EQ(left_out, expected);
}

// Joint control needs no tip: the same dynamics, with the frame behind the most joints for a tip.
TEST(ArmState, WithoutAGivenTipItHasTheSameDynamics) {
  const Model arm = sample_arms().at("planar_2R");
  ArmState without(arm), with(arm, {last_frame(arm)});
  const VectorXd q = Eigen::Vector2d(0.3, -0.7), dq = Eigen::Vector2d(0.5, 0.2);
  without.update(q, dq);
  with.update(q, dq);
  EXPECT_EQ(without.mass_matrix(), with.mass_matrix());
  EXPECT_EQ(without.bias(), with.bias());
  EXPECT_EQ(without.tip().position(), with.tip().position());
}

TEST(ArmState, RefusesUnknownTipsAndEffectsWithoutValues) {
  const Model arm = sample_arms().at("planar_2R");
  EXPECT_THROW(ArmState(arm, {"nowhere"}), InvalidInput);
  EXPECT_THROW(
      ArmState(with_effects(arm, {effect_on(arm, "rotor_inertia", 0, {})}), {last_frame(arm)}),
      InvalidInput);
  EXPECT_THROW(ComputedTorque(2, {VectorXd::Ones(2), VectorXd::Constant(2, -1.0)}), InvalidInput);
  const ArmState state(with_effects(arm, {effect_on(arm, "torque_drift", 0, {{"rate", 1.0}})}),
                       {last_frame(arm)});
  EXPECT_EQ(state.left_out(), std::vector<std::string>{"torque_drift(q1)"});
}

}  // namespace
}  // namespace veridyn
