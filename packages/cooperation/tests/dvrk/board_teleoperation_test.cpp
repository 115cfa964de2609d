#include "emulator/joined_arms.hpp"
#include "dvrk/cooperation/board_teleoperation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "dvrk/board_bench.hpp"
#include "veridyn/math/require.hpp"
#include "support/refusal.hpp"

// A master tool manipulator on emulated boards leads a patient side manipulator on others.

namespace veridyn::dvrk {
namespace {

std::vector<CooperatingArm> master_and_slave() {
  std::vector<CooperatingArm> arms;
  for (const char* name : {"MTMR", "PSM1"}) {
    const ArmFacts arm = read_arm(name);
    CooperatingArm one;
    one.robot = nominal_config(arm).robot("");
    one.coupling = arm.coupling();
    arms.push_back(one);
  }
  return arms;
}

TeleoperationScenario example() {
  return read_teleoperation(std::string(VERIDYN_SOURCE_DIR) +
                            "/examples/dvrk/mtm-psm-teleoperation.yaml");
}

TeleoperationRun run(const TeleoperationScenario& scenario,
                     const std::vector<EmulatedFault>& faults = {}) {
  BoardCooperationOptions options;
  options.emulate = emulate_boards;
  options.stepped = true;
  options.faults = faults;
  options.hold = 0.3;
  const std::atomic<bool> stop{false};
  return teleoperate_on_boards(scenario, master_and_slave(), options, stop);
}

TEST(BoardTeleoperation, TheFollowerMovesHalfAsFarAndRestsWhileTheClutchIsOut) {
  const TeleoperationScenario scenario = example();
  const TeleoperationRun done = run(scenario);
  ASSERT_EQ(done.end, BoardEnd::kDone) << done.report();
  ASSERT_EQ(done.phases.size(), 5U);
  EXPECT_EQ(done.power, OffState::kConfirmed);
  EXPECT_EQ(done.late, 0);
  // Half of what the leader's own tip went, which the hand leads by a spring.
  const Eigen::Index end = 1599;
  const Eigen::Vector3d led = (done.rows.block(end, 1, 1, 3) - done.rows.block(0, 1, 1, 3)).transpose();
  const Eigen::Vector3d went = (done.rows.block(end, 7, 1, 3) - done.rows.block(0, 7, 1, 3)).transpose();
  EXPECT_GT(led.norm(), 0.030);
  EXPECT_LT((went - 0.5 * led).norm(), 5e-4) << done.report();
  EXPECT_LT(done.tracking_largest[0], 1e-3);
  ASSERT_TRUE(done.latency);
  EXPECT_GT(*done.latency, 0.0);
  EXPECT_LT(*done.latency, 0.03);
  // The clutch is out: the follower rests while the leader goes back.
  EXPECT_LT(done.follower_moved[1], 3e-4);
  // Touching: the wall pushes the follower as much as the leader pushes the hand, but for the
  // leader's friction (0.02 N m at 0.3 m) and gravity that its model has right.
  EXPECT_GT(done.force_follower[3], 0.5) << done.report();
  EXPECT_NEAR(done.force_hand[3], done.force_follower[3], 0.35) << done.report();
  EXPECT_LT(done.force_follower[4], 0.05);
}

// No row before a phase is used, whatever the loop's rate, and a latency that no phase determines
// is not reported.
TEST(BoardTeleoperation, LatencyIsReportedOnlyForLongEnoughPhases) {
  TeleoperationScenario scenario = example();
  scenario.scenario.control.rate = 2500.0;
  for (const double seconds : {0.05, 0.3}) {
    scenario.scenario.phases.resize(1);
    scenario.steps.resize(1);
    scenario.scenario.phases[0].duration = seconds;
    const TeleoperationRun done = run(scenario);
    ASSERT_EQ(done.end, BoardEnd::kDone) << done.report();
    EXPECT_EQ(done.latency.has_value(), seconds > 0.06) << done.report();
    EXPECT_EQ(done.report().find("cannot be told") != std::string::npos, seconds < 0.06);
  }
}

TEST(BoardTeleoperation, APowerFaultOfEitherArmEndsTheRun) {
  for (const int arm : {0, 1}) {
    TeleoperationScenario scenario = example();
    scenario.scenario.phases.resize(1);
    scenario.steps.resize(1);
    const TeleoperationRun done = run(scenario, {{EmulatedFault::Kind::kPower, arm, 0.6}});
    EXPECT_EQ(done.end, BoardEnd::kFault) << done.report();
    EXPECT_NE(done.why.find(arm == 0 ? "arm mtm" : "arm psm"), std::string::npos) << done.why;
    EXPECT_LT(done.fault_at, 0.65);
    EXPECT_FALSE(done.met());
  }
}

// A hand that is faster than the follower's joints, and one that leads it out of reach.
TEST(BoardTeleoperation, InfeasibleStepsAreRefusedWithoutMotion) {
  for (const auto& [way, over] : {std::pair{0.08, 0.03}, {0.9, 3.0}}) {
    TeleoperationScenario scenario = example();
    scenario.steps[0].way = {way, 0.0, 0.0};
    scenario.steps[0].over = over;
    EXPECT_TRUE(refuses_with("Nothing was switched on", [&] { run(scenario); }));
  }
}

TEST(BoardTeleoperation, NamesInvalidSettings) {
  TeleoperationScenario scenario = example();
  scenario.options.scale = -1.0;
  EXPECT_THROW(run(scenario), InvalidInput);
  EXPECT_TRUE(is_teleoperation(std::string(VERIDYN_SOURCE_DIR) +
                               "/examples/dvrk/mtm-psm-teleoperation.yaml"));
  EXPECT_FALSE(is_teleoperation("/no/such/file"));
}

}  // namespace
}  // namespace veridyn::dvrk
