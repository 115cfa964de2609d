#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <string>

#include "emulator/joined_arms.hpp"
#include "dvrk/board_bench.hpp"
#include "dvrk/cooperation/board_cooperation.hpp"
#include "veridyn/files/model_file.hpp"

// One arm's fault stops all arms in a defined sequence: hold, release the pretension, power off.

namespace veridyn::dvrk {
namespace {

using Kind = EmulatedFault::Kind;

constexpr double kAt = 1.9;      // [s], while the object moves
constexpr double kRelief = 5.0;  // [N] that is held at most
constexpr double kHold = 0.4, kRelease = 1.0;  // [s]

struct Drill {
  Kind kind;
  const char* why;
  double found_within;  // [s]
  double force = 6.0;   // [N] that the spring carries at most
};

void PrintTo(const Drill& drill, std::ostream* out) { *out << drill.why; }

class BoardDrills : public testing::TestWithParam<Drill> {
 protected:
  static Scenario moving() {
    Scenario s = board_example("two-psm-spring");
    s.phases.resize(2);
    s.phases[0].duration = 1.5;
    s.phases[1].duration = 1.0;
    for (ScenarioCommand& c : s.phases[1].commands) c.over = 0.8;
    return s;
  }
};

TEST_P(BoardDrills, AfterAFaultArmsHoldThenReleaseThenSwitchOff) {
  const Drill& drill = GetParam();
  for (const int arm : {0, 1}) {
    SCOPED_TRACE(arm == 0 ? "master" : "slave");
    Scenario scenario = moving();
    // The pots are to find it, not the force sensor, which disagrees with the length sooner.
    if (drill.kind == Kind::kEncoder) scenario.control.drift_force = 1e9;
    const BoardCooperationRun done = on_emulated_boards(scenario, {{drill.kind, arm, kAt}});
    ASSERT_EQ(done.end, BoardEnd::kFault) << done.report();
    EXPECT_EQ(done.faulty_arm, arm) << done.why;
    EXPECT_NE(done.why.find("arm " + scenario.arms[arm].name + ": "),
              std::string::npos);
    EXPECT_NE(done.why.find(drill.why), std::string::npos) << done.why;
    EXPECT_FALSE(done.met());
    EXPECT_EQ(done.run.state, CooperativeState::kArmLost);
    EXPECT_GT(done.fault_at, kAt);
    EXPECT_LT(done.fault_at, kAt + drill.found_within);
    EXPECT_NEAR(done.release_at - done.fault_at, kHold, 0.02);
    EXPECT_NEAR(done.off_at - done.release_at, kRelease, 0.02);
    EXPECT_LT(done.largest_force, drill.force);
    EXPECT_LT(done.force_at_release, kRelief);
    EXPECT_LT(done.force_at_off, 1.0);
    // Boards that do not answer cannot confirm anything.
    EXPECT_EQ(done.power,
              drill.kind == Kind::kSilent ? OffState::kUnknown : OffState::kConfirmed);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Faults, BoardDrills,
    testing::Values(Drill{Kind::kSilent, "no reply", 0.03},
                    Drill{Kind::kAmplifier, "an amplifier is off", 0.06},
                    Drill{Kind::kPower, "no motor supply", 0.03},
                    Drill{Kind::kEncoder, "a pot disagrees", 0.5, 8.0},
                    Drill{Kind::kJump, "a position that jumped", 0.01}));

// Sensors fail as in the scenario: all arms stop, since forces are unknown, and power is switched off.
TEST(BoardDrills, AFailedForceSensorEndsTheRunWithPowerOff) {
  for (const auto kind : {ScenarioFault::Kind::kSensorStale, ScenarioFault::Kind::kSensorStuck}) {
    Scenario s = board_example("two-psm-spring");
    s.phases.resize(2);
    ScenarioFault fault;
    fault.kind = kind;
    fault.member = 0;
    fault.at = 0.8;  // while the force rises
    s.faults = {fault};
    const BoardCooperationRun done = on_emulated_boards(s);
    EXPECT_EQ(done.end, BoardEnd::kFault) << done.report();
    EXPECT_EQ(done.run.state, kind == ScenarioFault::Kind::kSensorStale
                                  ? CooperativeState::kSensorStale
                                  : CooperativeState::kSensorStuck);
    EXPECT_LT(done.largest_force, 6.0);
    EXPECT_EQ(done.power, OffState::kConfirmed);
  }
}

// A sensor that is suddenly off by 2 N while the spring keeps its length: nothing but the sensor has
// changed. Without the check of jumps the loop would use it.
TEST(BoardDrills, AForceSensorJumpIsDetectedWithin10Milliseconds) {
  Scenario s = board_example("two-psm-spring");
  s.phases.resize(1);
  ScenarioFault fault;
  fault.kind = ScenarioFault::Kind::kSensorJump;
  fault.member = 0;
  fault.at = 1.5;
  fault.by = -2.0;
  s.faults = {fault};
  const BoardCooperationRun done = on_emulated_boards(s);
  EXPECT_EQ(done.run.state, CooperativeState::kSensorJumped) << done.report();
  EXPECT_LT(done.fault_at, 1.51);
  EXPECT_LT(done.largest_force, 3.3);
  EXPECT_EQ(done.power, OffState::kConfirmed);
  s.control.jump_force = s.control.drift_force = 1e9;
  const BoardCooperationRun believed = on_emulated_boards(s);
  EXPECT_NE(believed.run.state, CooperativeState::kSensorJumped);
  EXPECT_GT(believed.largest_force, 4.5) << believed.report();
}

// An unbalanced arm loses its torque without a report, on a string: the other arm moves along
// with it. Without the guard the string carries several times as much.
TEST(BoardDrills, TheTetherGuardReducesTheStringForceOfAFallingArm) {
  std::ifstream file(std::string(VERIDYN_SOURCE_DIR) + "/examples/dvrk/light-psm.yaml");
  std::string model{std::istreambuf_iterator<char>(file), {}};
  const std::string balanced = "com: [-0.26, 0, 0]";
  const auto at = model.find(balanced);
  ASSERT_NE(at, std::string::npos);
  model.replace(at, balanced.size(), "com: [-0.20, 0, 0]");
  const std::string path = testing::TempDir() + "falling-psm.yaml";
  std::ofstream(path) << model;
  Scenario s = board_example("two-psm-string");
  for (ScenarioArm& arm : s.arms) arm.model = path;
  s.phases.resize(2);
  double guarded = 0.0;
  for (const bool guard : {true, false}) {
    s.control.guard = guard;
    BoardCooperationOptions options;
    options.emulate = emulate_boards;
    options.stepped = true;
    options.faults = {{Kind::kLimp, 1, 2.5}};
    const std::atomic<bool> stop{false};
    const BoardCooperationRun done = run_on_boards(s, patient_side(2), options, stop);
    EXPECT_EQ(done.end, BoardEnd::kFault) << done.report();
    EXPECT_LT(done.fault_at, 2.6);
    if (guard) {
      guarded = done.largest_force;
      EXPECT_LT(guarded, s.asked_largest_force) << done.report();
    } else {
      EXPECT_GT(done.largest_force, 2.0 * guarded) << done.report();
    }
  }
  std::remove(path.c_str());
}

}  // namespace
}  // namespace veridyn::dvrk
