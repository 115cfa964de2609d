#include "veridyn/dvrk/board_cooperation.hpp"

#include <gtest/gtest.h>

#include <string>

#include "veridyn/dvrk/arm_facts.hpp"

// Two arms on emulated boards, joined through a spring in one simulated world, over UDP sockets in
// real time. Bounds are wide: a busy machine is late, and late is no failure.

namespace veridyn::dvrk {
namespace {

Scenario scenario() {
  Scenario s = read_scenario(std::string(VERIDYN_SOURCE_DIR) + "/examples/dvrk/two-psm-spring.yaml");
  s.phases.resize(1);
  return s;
}

std::vector<CooperatingArm> arms() {
  std::vector<CooperatingArm> out(2);
  for (CooperatingArm& arm : out) {
    const ArmFacts facts = read_arm("PSM1");
    arm.robot = nominal_config(facts).robot("");
    arm.coupling = facts.coupling();
  }
  return out;
}

TEST(BoardCooperation, AForceIsBuiltUpOverSockets) {
  BoardCooperationOptions options;
  options.emulate = true;
  std::atomic<bool> stop{false};
  const BoardCooperationRun run = run_on_boards(scenario(), arms(), options, stop);
  EXPECT_EQ(run.end, BoardEnd::kDone) << run.why;
  EXPECT_GT(run.cycles, 1000);
  EXPECT_GT(run.largest_force, 1.0);
  EXPECT_LT(run.largest_force, 8.0);
}

// The boards of one arm fall silent: the other one gives up the pretension, then power goes.
TEST(BoardCooperation, OneArmsFaultStopsAll) {
  BoardCooperationOptions options;
  options.emulate = true;
  options.silent_arm = 1;
  options.fault_at = 1.2;
  options.hold = options.release = 0.3;
  std::atomic<bool> stop{false};
  const BoardCooperationRun run = run_on_boards(scenario(), arms(), options, stop);
  EXPECT_EQ(run.end, BoardEnd::kFault);
  EXPECT_EQ(run.faulty_arm, 1) << run.why;
  EXPECT_GT(run.fault_at, 1.2);
  EXPECT_LT(run.largest_force_after_fault, 10.0);
}

}  // namespace
}  // namespace veridyn::dvrk
