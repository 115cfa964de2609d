#include <gtest/gtest.h>

#include <functional>

#include "dvrk/bad_link.hpp"
#include "dvrk/planar_run.hpp"
#include "dvrk/rig.hpp"
#include "dvrk/run/arm_run.hpp"
#include "veridyn/control/joint_pid.hpp"
#include "dvrk/run/controllers/model_controller.hpp"
#include "veridyn/math/require.hpp"

// Runs on machines and networks that are late, or lose datagrams.

namespace veridyn::dvrk {
namespace {

class ArmTiming : public PlanarRun {};

// The loop of a run: update, PID, commit.
TEST_F(ArmTiming, ACycleDoesNotAllocate) {
  if (dvrk_malloc_count() < 0) GTEST_SKIP() << "the sanitizer has a malloc of its own";
  ArmSession arm(link_, planar_config());
  JointPid pid(sensible_gains(model_), {Eigen::Vector2d(10.0, 10.0), {}});
  arm.start();
  const VectorXd wanted = Eigen::Vector2d(0.4, -0.7);
  const VectorXd still = VectorXd::Zero(2);
  VectorXd tau = still;
  const auto cycles = [&](int count) {
    for (int k = 0; k < count; ++k) {
      link_.wait(1.0 / 1500.0);
      if (arm.update()) {
        pid.torques(arm.state().q, arm.state().dq, wanted, still, 1.0 / 1500.0, tau);
        arm.set_torques(tau);
      }
      arm.commit();
    }
  };
  cycles(5);
  ASSERT_EQ(arm.boards().power_on(), nullptr);
  cycles(300);
  ASSERT_EQ(arm.boards().state(), PowerState::kOn);
  const long before = dvrk_malloc_count();
  cycles(300);
  EXPECT_EQ(dvrk_malloc_count(), before);
  EXPECT_EQ(arm.boards().state(), PowerState::kOn);
}

// A controller that changes the network at its first call.
class ChangesTheNetwork final : public MotionController {
 public:
  explicit ChangesTheNetwork(std::function<void()> change) : change_(std::move(change)) {}
  void reset() noexcept override {}
  bool torques(const BoardArmState&, const JointReference&, const CycleTimes&,
               VectorXd& tau) noexcept override {
    tau.setZero();
    change_();
    return true;
  }
  std::string refusal_reason() const override { return ""; }
  bool follows() const override { return false; }

 private:
  std::function<void()> change_;
};

// Replies that are 5 ms late: 94 cycles per second in place of 1500.
TEST_F(ArmTiming, APersistentlyLateLoopIsStopped) {
  BadLink link(emulator_);
  ArmSession arm(link, planar_config());
  ChangesTheNetwork controller([&] { link.down.delay = 0.005; });
  const RunResult run = run_in_place(arm, link, 8.0, 2, controller, RunOptions(), stop_);
  EXPECT_FALSE(run.complete);
  EXPECT_NE(run.why.find("the loop is late"), std::string::npos) << run.why;
  // Under a sanitizer the boards, emulated in this program, work for longer than their replies take.
  const bool sanitized = dvrk_malloc_count() < 0;
  EXPECT_TRUE(sanitized || run.why.find("replies took") != std::string::npos) << run.why;
  EXPECT_EQ(run.power, OffState::kConfirmed);
  EXPECT_LT(link.now(), 3.0);
}

// The same from the start: no motor gets power, and the message names the reason.
TEST_F(ArmTiming, OnABusyMachineNoMotorGetsPower) {
  BadLink link(emulator_);
  ArmSession arm(link, planar_config());
  link.down.delay = 0.005;
  bool powered = false;
  ChangesTheNetwork controller([&] { powered = true; });
  const RunResult run = run_in_place(arm, link, 1.0, 2, controller, RunOptions(), stop_);
  EXPECT_FALSE(run.complete);
  EXPECT_FALSE(powered);
  EXPECT_NE(run.why.find("too busy"), std::string::npos) << run.why;
  EXPECT_NE(run.why.find("Nothing was moved"), std::string::npos) << run.why;
  EXPECT_EQ(run.power, OffState::kConfirmed);
}

// A stall before power is waited for.
TEST_F(ArmTiming, AStallBeforePowerIsTolerated) {
  BadLink link(emulator_);
  ArmSession arm(link, planar_config());
  int asked = 0;
  ChangesTheNetwork controller([&] { ++asked; });
  arm.start();
  link.down.lose = 1.0;
  arm.update();  // 20 ms without a reply
  link.down.lose = 0.0;
  const RunResult run = run_in_place(arm, link, 0.2, 2, controller, RunOptions(), stop_);
  EXPECT_TRUE(run.complete) << run.why;
  EXPECT_GT(asked, 250);
}

// One datagram of a hundred gets lost, both ways: a read is repeated within a millisecond.
// Without that a cycle waits 20 ms for it, and the run does not keep its rate.
TEST_F(ArmTiming, OnePercentOfPacketLossIsTolerated) {
  for (const bool again : {true, false}) {
    PlanarArm bench;
    BadLink link(bench.emulator, 7);
    ArmSessionOptions options;
    if (!again) options.repeat_after = 0.0;
    ArmSession arm(link, planar_config(), options);
    const Model model = read_model("planar-2r");
    ModelControlOptions law;
    law.law = ControlLaw::kComputedTorque;
    ModelController control(model, sensible_gains(model), largest_torques(arm), law);
    const MotionSamples way = swinging(4.0, Eigen::Vector2d(-0.4, 1.2), 0.4);
    arm.start();
    link.up.lose = link.down.lose = 0.01;
    RunOptions how;
    how.approach_speed = 1.0;
    RunResult run;
    try {
      run = run_motion(arm, link, way, control, how, bench.stop);
    } catch (const InvalidInput& error) {
      run.why = error.what();  // boards that were not found
    }
    EXPECT_EQ(run.complete, again) << run.why;
    if (again) {
      EXPECT_GT(run.timing.measured_rate(), 0.97 * 1500.0);
    }
  }
}

}  // namespace
}  // namespace veridyn::dvrk
