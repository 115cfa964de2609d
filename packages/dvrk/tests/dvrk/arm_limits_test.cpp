#include <gtest/gtest.h>

#include "dvrk/planar_run.hpp"
#include "dvrk/run/arm_run.hpp"
#include "dvrk/run/motion_check.hpp"
#include "support/refusal.hpp"

// Limits before power and under it, ends of pots, and the end stops of the emulated arm.

namespace veridyn::dvrk {
namespace {

class ArmLimits : public PlanarRun {};

class Untroubled final : public MotionController {
 public:
  void reset() noexcept override {}
  bool torques(const BoardArmState&, const JointReference&, const CycleTimes&, VectorXd&) noexcept override { return true; }
};

// The first actuator turns by the sum of both joints: a motion of the first joint alone does not determine its position.
TEST_F(ArmLimits, SoftLimitsApplyToActuatorsWhoseJointsAllMove) {
  ArmSessionOptions options;
  options.actuator_to_joint = (MatrixXd(2, 2) << 1.0, -1.0, 0.0, 1.0).finished();
  ArmSession arm(link_, planar_config(), options);
  const auto refused = [&](const VectorXd& q) {
    MotionSamples stands;
    stands.time = Eigen::Vector2d(0.0, 0.01);
    stands.q = VectorXd::Ones(2) * q.transpose();
    stands.dq = MatrixXd::Zero(2, q.size());
    return refusal([&] { MotionCheck(arm, Untroubled(), q.size()).require_inside(stands, 1500.0); });
  };
  EXPECT_EQ(refused(Eigen::Vector2d(2.7, -0.7)), "");
  EXPECT_NE(refused(Eigen::Vector2d(2.7, 0.0)).find("actuator 0 to 2.7"), std::string::npos);
  EXPECT_EQ(refused(VectorXd::Constant(1, 2.7)), "");
}

// The supervisor's test of position limits, position plus velocity over 30, is made of the whole
// motion before power comes on: never beyond 2.49 rad of 2.5, but too fast there.
TEST_F(ArmLimits, AMotionThatCouldNotStopBeforeALimitIsRefusedBeforePower) {
  ArmSession arm(link_, planar_config());
  const PidGains gains = sensible_gains(model_);
  MotionSamples fast = swinging(4.0, Eigen::Vector2d(1.69, 0.1), 0.8);
  ASSERT_LT(fast.q.maxCoeff(), 2.4901);
  EXPECT_TRUE(refuses_with("--limit-share", [&] { run_motion(arm, link_, fast, gains, RunOptions(), stop_); }));
  EXPECT_EQ(emulator_.counters().writes, 0);
  EXPECT_FALSE(emulator_.board(0).status().power_requested());
  const MotionSamples slower = swinging(8.0, Eigen::Vector2d(1.69, 0.1), 0.74);
  const RunResult run = run_motion(arm, link_, slower, gains, RunOptions(), stop_);
  EXPECT_TRUE(run.complete) << run.why;
}

// With a PID nothing but the soft limits holds an arm that runs away: here it is thrown.
TEST_F(ArmLimits, SoftLimitsEndARunWithAPid) {
  bool thrown = false;  // before the session, which waits once more when it ends
  WatchedLink link(emulator_);
  ArmSession arm(link, planar_config());
  link.each = [&](double now) {
    if (thrown || now < 5.0) return;
    thrown = true;
    plant_.set_state(Eigen::Vector2d(0.1, 2.3), Eigen::Vector2d(0.0, 8.0));  // 2.3 + 8/30 > 2.5
  };
  RunOptions options;
  options.largest_error = Eigen::Vector2d(9.0, 9.0);  // so large that it does not end the run
  const RunResult run = run_motion(arm, link, motion(8.0), sensible_gains(model_), options, stop_);
  EXPECT_TRUE(thrown);
  EXPECT_FALSE(run.complete);
  EXPECT_NE(run.why.find("actuator 1 leaves its soft limits"), std::string::npos) << run.why;
  EXPECT_EQ(run.power, OffState::kConfirmed);
  EXPECT_FALSE(emulator_.board(0).amp_on(1));
}

// A pot with a broken wire reads zero: encoders are not loaded from it, and no motor is driven.
TEST_F(ArmLimits, APotAtItsRailPreventsHomingAndPower) {
  emulator_.board(0).faults.pot_wire[1] = true;
  ArmSession arm(link_, planar_config());
  EXPECT_TRUE(refuses_with("pot of actuator 1", [&] { arm.start(); }));
  emulator_.board(0).faults.pot_wire[1] = false;
  link_.wait(0.01);
  arm.start();
  emulator_.board(0).faults.pot_wire[1] = true;
  link_.wait(0.01);
  ASSERT_TRUE(arm.update());
  EXPECT_NE(arm.power_on(), nullptr);
}

TEST_F(ArmLimits, AnArmOutsideItsLimitsIsNotDriven) {
  RobotConfig narrow = planar_config();
  narrow.actuators[0].upper = 0.2;  // it stands at 0.4
  ArmSession arm(link_, narrow);
  arm.start();
  ASSERT_TRUE(arm.update());
  ASSERT_EQ(arm.homing().outside_limits, std::vector<int>{0});
  EXPECT_NE(arm.power_on(), nullptr);
  EXPECT_FALSE(emulator_.board(0).status().power_requested());
}

TEST_F(ArmLimits, EmulatedEndStopsStopAPushedArm) {
  load_.set_end_stops(Eigen::Vector2d(-0.5, -0.8), Eigen::Vector2d(0.5, 0.8));
  plant_.set_state(Eigen::Vector2d(0.4, -0.7), Eigen::Vector2d(3.0, -3.0));
  ArmSession arm(link_, planar_config());
  arm.start();
  ASSERT_TRUE(arm.update());
  ASSERT_EQ(arm.power_on(), nullptr);
  for (int k = 0; k < 1500; ++k) {
    link_.wait(1.0 / 1500.0);
    arm.update();
    arm.set_torques(Eigen::Vector2d(60.0, -40.0));
    arm.commit();
    ASSERT_LE(plant_.q()[0], 0.5 + 1e-12);
    ASSERT_GE(plant_.q()[1], -0.8 - 1e-12);
  }
  EXPECT_EQ(plant_.q()[0], 0.5);
  EXPECT_EQ(plant_.dq()[0], 0.0);
}

}  // namespace
}  // namespace veridyn::dvrk
