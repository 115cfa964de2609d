#include "veridyn/control/joint_controller.hpp"

#include <gtest/gtest.h>

#include <sstream>

#include "control/arm_rig.hpp"
#include "control/psm_like.hpp"
#include "support/malloc_count.hpp"
#include "veridyn/control/tip_controller.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

const Tip kTip{"tool"};

CycleOptions with_limits() {
  CycleOptions options;
  options.torque = 40.0;
  return options;
}

// A model that knows errors of its sensors.
Model with_sensor_errors(const Model& arm) {
  ModelDescription d = arm.description();
  d.coordinates[0].recorded.position_offset = 0.02;
  d.coordinates[1].recorded.torque_gain = 1.2;
  d.coordinates[2].recorded.torque_crosstalk = {{{0}, 0.1}};
  return Model(std::move(d));
}

// A motion as the encoders show it, and what is wanted, both smooth.
void at(int cycle, Measured& measured, JointReference& wanted) {
  for (int i = 0; i < 3; ++i) {
    const double size = i == 2 ? 0.03 : 0.2, w = 3.0 + i, t = kPeriod * cycle;
    wanted.q[i] = 0.1 + size * std::sin(w * t);
    wanted.dq[i] = size * w * std::cos(w * t);
    wanted.ddq[i] = -size * w * w * std::sin(w * t);
    measured.q[i] = wanted.q[i] - 1e-3 * std::sin(7.0 * t);
  }
}

// The parts in the order that ArmState, ComputedTorque and the others document, by hand.
TEST(JointController, TorqueEqualsThatOfItsComponentsInSequence) {
  const Model arm = with_sensor_errors(psm_like());
  JointController controller(arm, {{25, 20, 75}, {10, 11, 15}, 0.0, {}, with_limits()});
  JointSensors sensors(arm);
  VelocityObserver velocity(3);
  ArmState state(arm);
  ComputedTorque law(3, {Eigen::Vector3d(25, 20, 75), Eigen::Vector3d(10, 11, 15)});
  FrictionCompensation friction(arm);
  TorqueUncertainty uncertainty(arm);
  ModelErrorObserver error(3, {10.0, VectorXd::Zero(3)});
  SafetySupervisor safety(arm, safety_limits(arm, 40.0));
  safety.enable();
  safety.activate();
  SafetyInput input(3);
  input.force_expected.setConstant(NAN);
  Measured measured(3);
  JointReference wanted(3);
  VectorXd off(3), tau(3), sent(3);
  for (int k = 0; k < 500; ++k) {
    at(k, measured, wanted);
    VectorXd q = measured.q;
    sensors.correct_positions(q);
    state.update(q, velocity.update(q, law.acceleration(), kPeriod));
    off = wanted.q - q;
    tau = law.update(state, wanted);
    tau += friction.update(state, wanted.dq, off, kPeriod);
    if (k % 16 == 0) error.set_limit(uncertainty.update(state, law.acceleration()));
    tau += error.update(state, law.acceleration(), kPeriod);
    input.q_wanted = wanted.q;
    safety.set_holding_torque(error.torque());
    sent = safety.update(state, input, tau);
    error.set_sent_torques(tau, sent);
    sensors.add_torque_errors(sent);
    ASSERT_EQ(controller.update(measured, wanted, kPeriod), sent) << k;
  }
  EXPECT_FALSE(controller.fault());
  EXPECT_GT(controller.cycle().error().torque().norm(), 0.0);
}

TEST(JointController, AFaultReportsItsKindJointAndTime) {
  JointController controller(psm_like(), {400, 40, 0, {}, with_limits()});
  Measured measured(3);
  JointReference wanted(3);
  for (int k = 1; k <= 120; ++k) {
    at(k, measured, wanted);
    if (k >= 100) measured.q[1] = NAN;
    EXPECT_TRUE(controller.update(measured, wanted, kPeriod).allFinite());
    ASSERT_EQ(controller.fault().has_value(), k >= 100) << k;
  }
  const ControllerFault fault = *controller.fault();
  EXPECT_EQ(fault.what, SafetyFault::kNotFinite);
  EXPECT_EQ(fault.joint, JointIndex{1});
  EXPECT_NEAR(fault.time, 0.1, 1e-9);
  std::ostringstream words;
  words << fault;
  EXPECT_EQ(words.str(), std::string(describe(fault.what)) + " of joint 2 at 0.1 s");
  controller.reset();
  EXPECT_FALSE(controller.fault());
}

// A simulated arm under a controller, for `seconds`.
template <typename Controller, typename Reference>
void run(Controller& controller, const Reference& wanted, double seconds, ArmRig& rig) {
  Measured measured(3);
  for (int k = 0; k < static_cast<int>(seconds / kPeriod); ++k) {
    measured.q = rig.q();
    measured.wrench = rig.wrench();
    ASSERT_EQ(rig.cycle(controller.update(measured, wanted, kPeriod)), StepStatus::kOk);
  }
}

TEST(JointController, HoldsThenYieldsToAPushThenResumesTracking) {
  const Model real = psm_like();
  ArmRig rig(real, kTip);
  rig.place(Eigen::Vector3d(0.1, 0.05, 0.12));
  JointController controller(with_wrong_parameters(real, 0.05, 1), {400, 40, 0, {}, with_limits()});
  JointReference wanted(3);
  wanted.q = rig.q();
  run(controller, wanted, 0.5, rig);
  ASSERT_TRUE(controller.hold());
  const VectorXd held = rig.q();
  wanted.q[0] += 0.5;  // does not count
  run(controller, wanted, 0.5, rig);
  EXPECT_LT((rig.q() - held).cwiseAbs().maxCoeff(), 5e-3);
  // Limp: the arm does not fall, but a push moves it, which it would not while it follows.
  controller.limp();
  run(controller, wanted, 0.5, rig);
  EXPECT_LT((rig.q() - held).cwiseAbs().maxCoeff(), 0.02);
  rig.set_world([](const Eigen::Vector3d&, const Eigen::Vector3d&) { return Eigen::Vector3d(-8, 0, 0); });
  const Eigen::Vector3d before = rig.tip().position();
  run(controller, wanted, 0.6, rig);
  EXPECT_GT(rig.tip().position().x() - before.x(), 0.01);
  rig.set_world({});
  run(controller, wanted, 0.5, rig);
  wanted.q = rig.q();
  controller.resume();
  run(controller, wanted, 1.0, rig);
  EXPECT_LT((rig.q() - wanted.q).cwiseAbs().maxCoeff(), 2e-3);
  EXPECT_FALSE(controller.fault()) << *controller.fault();
}

// Drives that give no more than what carries the arm: where the controller is told so, its observer
// does not take the rest for an error of the model.
TEST(JointController, TorqueThatTheMotorsDidNotReceiveIsNoModelError) {
  const Model arm = psm_like();
  double observed[2];
  for (const bool tells : {false, true}) {
    CycleOptions cycle = with_limits();
    cycle.error_limit = 100.0;
    JointController controller(arm, {400, 40, 0, {}, cycle});
    Measured measured(3);
    JointReference wanted(3);
    measured.q = wanted.q = Eigen::Vector3d(0.1, 0.05, 0.12);
    wanted.q[0] += 0.01;  // the arm stays where it is
    for (int k = 0; k < 200; ++k) {
      controller.update(measured, wanted, kPeriod);
      if (tells) controller.set_sent_torques(controller.state().bias());
    }
    observed[tells ? 1 : 0] = controller.cycle().error().torque().norm();
  }
  EXPECT_LT(observed[1], 0.1 * observed[0]);
}

// The integral of a joint that cannot get where it should stops at the motor's limit.
TEST(JointController, PidDoesNotWindUp) {
  const Model real = psm_like();
  CycleOptions cycle = with_limits();
  cycle.torque = 5.0;
  cycle.limits = safety_limits(real, 5.0);
  cycle.limits->torque_seconds = cycle.limits->tracking[0] = 10.0;
  JointController controller(real, {100, 5, 50, JointLaw::kPid, cycle});
  Measured measured(3);
  JointReference wanted(3);
  measured.q = wanted.q = Eigen::Vector3d(0.1, 0.05, 0.12);
  wanted.q[0] += 1.0;
  for (int k = 0; k < 2000; ++k) controller.update(measured, wanted, kPeriod);
  wanted.q[0] = measured.q[0] - 0.05;
  controller.update(measured, wanted, kPeriod);
  EXPECT_FALSE(controller.fault());
  EXPECT_LT(controller.cycle().commanded()[0], 0.0);
}

TEST(JointController, GravityCompensationHoldsTheArmWithoutTracking) {
  const Model real = psm_like();
  JointController controller(real, {400, 40, 0, JointLaw::kGravity, with_limits()});
  GravityCompensation gravity(real);
  Measured measured(3);
  measured.q = Eigen::Vector3d(0.1, 0.05, 0.12);
  JointReference wanted(3);
  wanted.q.setConstant(0.3);
  EXPECT_EQ(controller.update(measured, wanted, kPeriod), gravity.update(measured.q));
}

TEST(JointController, RejectsInvalidOptions) {
  const Model arm = psm_like();
  const auto message = [&](const JointControllerOptions& options) {
    try {
      JointController controller(arm, options);
    } catch (const InvalidInput& bad) {
      return std::string(bad.what());
    }
    return std::string();
  };
  EXPECT_NE(message({400, 40}).find("'yaw'"), std::string::npos);  // the file has no torque limit
  EXPECT_NE(message({{1, 2}, 40, 0, {}, with_limits()}).find("kp"), std::string::npos);
  EXPECT_NE(message({400, -1, 0, {}, with_limits()}).find("kd"), std::string::npos);
  EXPECT_EQ(message({400, 40, 0, {}, with_limits()}), "");
}

TEST(JointController, RejectsAnEmptyModel) {
  EXPECT_THROW(JointController{Model()}, InvalidInput);
  EXPECT_THROW(TipController{Model()}, InvalidInput);
}

TEST(TipController, PullsASpringWithTheForceOfTheImpedanceEquation) {
  const Model real = psm_like();
  ArmRig rig(real, kTip);
  rig.place(Eigen::Vector3d(0.1, 0.05, 0.12));
  const Eigen::Vector3d start = rig.tip().position();
  rig.set_world([=](const Eigen::Vector3d& x, const Eigen::Vector3d&) -> Eigen::Vector3d {
    return 1000.0 * (x - start);
  });
  TipControllerOptions options{2, 100, 100, kTip, {}, with_limits()};
  TipController controller(with_wrong_parameters(real, 0.05, 1), options);
  Measured measured(3);
  measured.q = rig.q();
  TaskReference wanted = controller.reference_at(measured);
  EXPECT_LT((wanted.x.head<3>() - start).norm(), 1e-4);
  wanted.x[0] += 0.055;  // two springs in series: 5 N
  run(controller, wanted, 4.0, rig);
  EXPECT_NEAR(rig.force().norm(), 5.0, 0.5);
  EXPECT_FALSE(controller.fault()) << *controller.fault();
  EXPECT_TRUE(controller.hold());
}

TEST(Controllers, NoUpdateAllocates) {
  if (VERIDYN_COUNTS_MALLOC == 0) GTEST_SKIP() << "the sanitizer has a malloc of its own";
  const Model arm = with_sensor_errors(plausible_model(read_model("psm-wrist"), 1).arm);
  const int n = arm.joints();
  CycleOptions cycle = with_limits();
  Measured measured(n);
  JointReference wanted(n);
  for (const JointLaw law : {JointLaw::kComputedTorque, JointLaw::kGravity, JointLaw::kPid}) {
    JointController controller(arm, {400, 40, 1, law, cycle});
    int faults = 0;
    const long before = malloc_count();
    for (int k = 0; k < 200; ++k) {
      measured.q.setConstant(0.1 + 1e-4 * k);
      wanted.q = measured.q;
      if (k == 150) measured.q[2] = NAN;
      if (k == 50) controller.hold();
      if (k == 80) controller.limp();
      if (k == 120) controller.resume();
      controller.set_sent_torques(controller.update(measured, wanted, kPeriod));
      if (k < 190) continue;
      faults += controller.fault().has_value();
      controller.reset();
    }
    EXPECT_EQ(malloc_count(), before) << static_cast<int>(law);
    EXPECT_EQ(faults, 1);
  }
  TipController controller(arm, {2, 80, 800, {"yaw1"}, {}, cycle});
  TaskReference task;
  const long before = malloc_count();
  for (int k = 0; k < 200; ++k) {
    measured.q.setConstant(0.1 + 1e-4 * k);
    controller.update(measured, task, kPeriod);
  }
  EXPECT_EQ(malloc_count(), before);
}

}  // namespace
}  // namespace veridyn
