#include "veridyn/simulation/hidden_effect.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "simulation_support.hpp"
#include "support/near.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/kinematics/kinematics.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/math/vector3.hpp"
#include "veridyn/simulation/plausible_model.hpp"

namespace veridyn {
namespace {

// What an effect changes in the recorded torques.
MatrixXd change(const Model& arm, const std::string& effect) {
  return simulated(arm, {effect}).tau - simulated(arm, {}).tau;
}

MatrixXd only_column(const MatrixXd& like, int column, const VectorXd& values) {
  MatrixXd out = MatrixXd::Zero(like.rows(), like.cols());
  out.col(column) = values;
  return out;
}

TEST(HiddenEffect, ViscousFrictionChangesItsJointByItsFormula) {
  const Model arm = read_model("elbow-6r");
  const MatrixXd d = change(arm, "viscous_friction:elbow:coefficient=2.5");
  EXPECT_TRUE(near(d, only_column(d, 2, 2.5 * waves(6).dq.col(2)), 1e-11));
  EXPECT_TRUE(near(change(arm, "viscous_friction:3:coefficient=5/2"), d, 0.0));
}

TEST(HiddenEffect, RotorInertiaChangesItsJointByItsFormula) {
  const MatrixXd d = change(read_model("scara"), "rotor_inertia:quill:inertia=0.3");
  EXPECT_TRUE(near(d, only_column(d, 2, 0.3 * waves(4).ddq.col(2)), 1e-11));
}

TEST(HiddenEffect, SignalFaultsActOnTheirJointAlone) {
  const Model arm = read_model("scara");
  const SimulatedRecording ideal = simulated(arm, {});
  EXPECT_TRUE(near(change(arm, "torque_gain:2:gain=1.1"),
                   only_column(ideal.tau, 1, 0.1 * ideal.tau.col(1)), 1e-12));
  EXPECT_TRUE(near(change(arm, "torque_drift:elbow:rate=0.2"),
                   only_column(ideal.tau, 1, 0.2 * waves(4).time), 1e-12));
  const SimulatedRecording offset = simulated(arm, {"encoder_offset:wrist:offset=0.01"});
  EXPECT_TRUE(near(offset.tau, ideal.tau, 0.0));
  EXPECT_TRUE(near(offset.measured.q - ideal.measured.q,
                   only_column(ideal.tau, 3, VectorXd::Constant(2001, 0.01)), 1e-15));
}

// A delay of two rows is a shift by two rows.
TEST(HiddenEffect, DelayShiftsTheTorque) {
  const Model arm = read_model("planar-2r");
  const MatrixXd tau = simulated(arm, {}).tau;
  const MatrixXd late = simulated(arm, {"time_delay:1:seconds=0.01"}).tau;
  EXPECT_TRUE(near(late.col(0).segment(2, 1999), tau.col(0).head(1999), 1e-8 * tau.norm()));
  EXPECT_TRUE(near(late.col(1), tau.col(1), 0.0));
}

TEST(HiddenEffect, ContactActsDuringItsTimeOnly) {
  const MatrixXd d = change(read_model("planar-2r"), "external_contact:elbow:from=2,to=3,effort=4");
  EXPECT_TRUE(near(d.col(0), VectorXd::Zero(2001), 0.0));
  for (Eigen::Index k = 0; k <= 2000; ++k) {
    const double t = 0.005 * static_cast<double>(k);
    const bool touches = t > 2.0 && t < 3.0;
    const bool fully = t > 2.11 && t < 2.89;
    EXPECT_TRUE(touches || d(k, 1) == 0.0) << t;
    EXPECT_TRUE(!fully || std::abs(d(k, 1) - 4.0) < 1e-12) << t << ": " << d(k, 1);
  }
}

// A point mass at a place of its frame is a body there; its torque follows from the parallel-axis
// terms alone.
TEST(HiddenEffect, PayloadHasTheTorquesOfAPointMass) {
  const Model arm = read_model("planar-2r");
  const MotionSamples m = waves(2);
  const MatrixXd d = change(arm, "payload:fore:mass=0.5");
  // At the end of the second rod: m l^2 terms of a double pendulum with point masses.
  const double l1 = 0.5;
  const double l2 = 0.4;
  const double mass = 0.5;
  for (const Eigen::Index k : {Eigen::Index{0}, Eigen::Index{500}, Eigen::Index{1300}}) {
    const double q1 = m.q(k, 0);
    const double q2 = m.q(k, 1);
    const double c2 = std::cos(q2);
    const double s2 = std::sin(q2);
    const double both = m.ddq(k, 0) + m.ddq(k, 1);
    const double g = 9.81;
    const double tau2 =
        mass * (l2 * l2 * both + l1 * l2 * c2 * m.ddq(k, 0) +
                l1 * l2 * s2 * m.dq(k, 0) * m.dq(k, 0) + g * l2 * std::cos(q1 + q2));
    const double w = m.dq(k, 0) + m.dq(k, 1);
    const double tau1 = tau2 + mass * (l1 * l1 * m.ddq(k, 0) + l1 * l2 * c2 * both -
                                       l1 * l2 * s2 * w * w + g * l1 * std::cos(q1));
    EXPECT_NEAR(d(k, 1), tau2, 1e-10);
    EXPECT_NEAR(d(k, 0), tau1, 1e-10);
  }
}

TEST(HiddenEffect, PayloadOnAFrameWithoutABodyAddsOne) {
  const Model arm = read_model("scara");
  EXPECT_EQ(simulated(arm, {"payload:column:mass=1"}).truth.bodies().size(),
            arm.bodies().size() + 1);
}

// Turning the base and the gravity together changes nothing: a tilt is a turned gravity.
TEST(HiddenEffect, TiltTurnsGravityInTheBase) {
  const Model arm = read_model("elbow-6r");
  const SimulatedRecording s = simulated(arm, {"gravity_tilt:arm:roll=0.1,pitch=-0.2"});
  const Vec3d g =
      rotate(rotation_y(-0.2) * rotation_x(0.1),
             Vec3d{s.truth.gravity().x(), s.truth.gravity().y(), s.truth.gravity().z()});
  EXPECT_NEAR(g.x, 0.0, 1e-14);
  EXPECT_NEAR(g.y, 0.0, 1e-14);
  EXPECT_NEAR(g.z, -9.81, 1e-14);
}

// A number of a frame's row, a ratio of a coupled joint, and a joint's zero.
TEST(HiddenEffect, DhNumbersAndEncoderZerosCanBeChanged) {
  const Model arm = plausible_model(read_model("planar-2r"), 1).arm;
  const VectorXd q = VectorXd::Constant(2, 0.3);
  const VectorXd rest = VectorXd::Zero(2);
  const auto torque = [&](const Model& one, const VectorXd& at) {
    return inverse_dynamics(one, at, rest, rest);
  };
  const Model turned = simulated(arm, {"coupling_error:fore.theta:change=0.2"}).truth;
  EXPECT_NEAR(turned.frames()[1].variable.offset, 0.2, 1e-15);
  VectorXd ahead = q;
  ahead[1] += 0.2;
  EXPECT_TRUE(near(torque(turned, q), torque(arm, ahead), 1e-9));
  const Model zero = simulated(arm, {"coupling_error:elbow.zero:change=0.2"}).truth;
  EXPECT_TRUE(near(torque(zero, q), torque(arm, ahead), 1e-9));
  const Model longer = simulated(arm, {"coupling_error:upper.a"}).truth;
  EXPECT_NEAR(longer.frames()[0].dh->a, 0.55, 1e-12);
  const Model wrist = plausible_model(read_model("psm-wrist"), 1).arm;
  const PerturbedArm ratio =
      inject_effects(wrist, {parse_hidden_effect("coupling_error:wrist_pitch.ratio of pitch_motor:change=0.5")});
  const int k = wrist.find_frame("wrist_pitch")->value;
  const int i = wrist.find_coordinate("pitch_motor")->value;
  EXPECT_NEAR(ratio.arm.frames()[k].variable.coefficients[i],
              wrist.frames()[k].variable.coefficients[i] + 0.5, 1e-12);
}

// Frames without rows, as those of a URDF: an origin is shifted along the parent's axes.
TEST(HiddenEffect, NumbersOfAFrameOriginCanBeChanged) {
  ModelDescription d = plausible_model(read_model("planar-2r"), 1).arm.description();
  for (Frame& frame : d.frames) frame.dh.reset();
  const Model arm(std::move(d));
  const FrameIndex k = *arm.find_frame("fore");
  const PerturbedArm shifted = inject_effects(arm, {parse_hidden_effect("coupling_error:fore.y:change=0.02")});
  const VectorXd q = VectorXd::Zero(2);
  const Eigen::Vector3d way =
      frame_pose(shifted.arm, q, k).translation() - frame_pose(arm, q, k).translation();
  EXPECT_TRUE(near(way, Eigen::Vector3d(0.0, 0.02, 0.0), 1e-12));
  EXPECT_THROW(inject_effects(arm, {parse_hidden_effect("coupling_error:fore.theta")}), InvalidInput);
}

TEST(HiddenEffect, AWrongConstantGivesTheTorquesOfTheArmWithThatConstant) {
  const Model arm = plausible_model(read_model("psm-3dof"), 1).arm;
  const SimulatedRecording s = simulated(arm, {"coupling_error:delta:change=0.1"});
  EXPECT_NEAR(s.truth.description().constants.at("delta"), 0.6, 1e-15);
  ModelFileOptions options;
  options.constants["delta"] = 0.6;
  const Model other = plausible_model(read_model("psm-3dof", options), 1).arm;
  const VectorXd q = VectorXd::Constant(3, 0.1);
  const VectorXd rest = VectorXd::Zero(3);
  EXPECT_TRUE(
      near(inverse_dynamics(s.truth, q, rest, rest), inverse_dynamics(other, q, rest, rest), 1e-9));
  EXPECT_GT((inverse_dynamics(arm, q, rest, rest) - inverse_dynamics(other, q, rest, rest)).norm(),
            1e-3);
}

double rms(const VectorXd& x) {
  return std::sqrt(x.squaredNorm() / static_cast<double>(x.size()));
}

TEST(HiddenEffect, EveryEffectActsOnItsJointAlone) {
  const Model arm = read_model("elbow-6r");
  for (const AxisEffect* effect : axis_effects()) {
    if (effect->name() == "tabulated_force") continue;  // a table has no size of its own
    const bool coupled = effect->traits().uses_source;
    const MatrixXd d = change(arm, effect->name() + ":shoulder" + (coupled ? ":from=elbow" : ""));
    EXPECT_GT(rms(d.col(1)), 0.0) << effect->name();
    EXPECT_TRUE(near(d, only_column(d, 1, d.col(1)), 0.0)) << effect->name();
  }
}

// The rms of a sign is one. Gravity makes most of the shoulder's effort, so it is much the same on
// any slow motion.
TEST(HiddenEffect, DefaultSizesAreATenthOfTheEffort) {
  const Model arm = read_model("elbow-6r");
  const double level = simulated(arm, {"coulomb_friction:shoulder"}).injected[0].values.at("level");
  EXPECT_NEAR(level / rms(simulated(arm, {}).tau.col(1)), 0.1, 0.05);
}

// Rows at 4 Hz with 50 substeps against rows at 200 Hz: quintics through position, velocity and
// acceleration of waves below 3 rad/s are right to (h / 2)^6 * 3^6 / 720 of 0.1 rad: 1e-6 rad.
TEST(HiddenEffect, HysteresisIsIntegratedBetweenRows) {
  const Model arm = read_model("planar-2r");
  const MotionSamples fine = waves(2);
  const auto coarse = Eigen::seqN(0, 41, 50);
  SimulationOptions options;
  options.hidden = {parse_hidden_effect("presliding_hysteresis:1:level=2,distance=0.005")};
  options.substeps = 1;
  const MatrixXd expected = simulate_recording(arm, fine, options).tau(coarse, Eigen::all);
  options.substeps = 50;
  const MatrixXd tau =
      simulate_recording(arm,
                         {fine.time(coarse), fine.q(coarse, Eigen::all),
                          fine.dq(coarse, Eigen::all), fine.ddq(coarse, Eigen::all)},
                         options)
          .tau;
  EXPECT_TRUE(near(tau, expected, 1e-3));
}

TEST(HiddenEffect, DefaultSizesDependOnTheArmAndNotOnTheMotion) {
  const Model arm = read_model("scara");
  SimulationOptions options;
  options.hidden = {parse_hidden_effect("coulomb_friction:1")};
  const double one = simulate_recording(arm, waves(4, 0.1), options).injected[0].values.at("level");
  const double two = simulate_recording(arm, waves(4, 0.05), options).injected[0].values.at("level");
  EXPECT_GT(one, 0.0);
  EXPECT_EQ(one, two);
}

TEST(HiddenEffect, TwoEffectsAddUp) {
  const Model arm = read_model("scara");
  const MatrixXd both =
      simulated(arm, {"viscous_friction:1:coefficient=1", "rotor_inertia:2:inertia=0.1"}).tau;
  const MatrixXd sum =
      change(arm, "viscous_friction:1:coefficient=1") + change(arm, "rotor_inertia:2:inertia=0.1");
  EXPECT_TRUE(near(both - simulated(arm, {}).tau, sum, 1e-12));
}

std::string message_of(const std::string& effect) {
  try {
    simulated(plausible_model(read_model("psm-3dof"), 1).arm, {effect});
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "nothing was thrown";
}

bool says(const std::string& effect, const std::string& words) {
  const std::string message = message_of(effect);
  const bool found =
      message.find(words) != std::string::npos && message.find('\n') == std::string::npos;
  if (!found) ADD_FAILURE() << effect << ": " << message;
  return found;
}

TEST(HiddenEffect, InvalidRequestsAreRefusedWithASuggestion) {
  EXPECT_TRUE(says("viscos_friction:1", "did you mean 'viscous_friction'?"));
  EXPECT_TRUE(says("viscous_friction", "found no place"));
  EXPECT_TRUE(says("viscous_friction:yav", "did you mean 'yaw'?"));
  EXPECT_TRUE(says("viscous_friction:4", "a number from 1 to 3"));
  EXPECT_TRUE(says("viscous_friction:0", "a number from 1 to 3"));
  EXPECT_TRUE(says("viscous_friction:1:coeficient=1", "did you mean 'coefficient'?"));
  EXPECT_TRUE(says("viscous_friction:1:coefficient", "expected KEY=VALUE"));
  EXPECT_TRUE(says("viscous_friction:1:coefficient=", "expected KEY=VALUE"));
  EXPECT_TRUE(says("viscous_friction:1:coefficient=much", "viscous_friction:1:coefficient=much"));
  EXPECT_TRUE(says("viscous_friction:1:coefficient=1,coefficient=2", "twice"));
  EXPECT_TRUE(says("viscous_friction:1:coefficient=1:more", "more than two ':'"));
  EXPECT_TRUE(says("viscous_friction:1:from=2", "the key 'from'"));
  EXPECT_TRUE(says("payload:tol:mass=1", "did you mean 'tool'?"));
  EXPECT_TRUE(says("payload:tool:mass=-1", "a positive one"));
  EXPECT_TRUE(says("coupling_error:delt", "did you mean 'delta'?"));
  EXPECT_TRUE(says("torque_gain:1:gains=2", "did you mean 'gain'?"));
  EXPECT_TRUE(says("external_contact:1:from=3,to=2", "to end after it begins"));
  EXPECT_TRUE(says("time_delay:1:seconds=-1", "none below zero"));
}

}  // namespace
}  // namespace veridyn
