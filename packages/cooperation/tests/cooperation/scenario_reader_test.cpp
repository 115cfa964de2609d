#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "veridyn/cooperation/scenario.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/simulation/object.hpp"
#include "support/refusal.hpp"

namespace veridyn {
namespace {

const char* const kGood = R"(veridyn: 1
scenario: two slides
arms:
  - {name: left, model: psm-3dof, frame: tool, start: [0, 0, 0.1], control: position}
  - {name: right, model: psm-3dof, position: [1, 0, 0], turn: [0, 0, pi], frame: tool, start: [0, 0, 0.1], control: impedance}
master: right
members:
  - {name: rope, kind: string, between: [left, right], stiffness: 2450, damping: 2, sensor: {rate: 500, delay: 0.002}, law: {kind: proportional, gain: 0.1}}
phases:
  - {name: pull, duration: 2, over: 1, force: 5, move: [0.01, 0, 0], ask: {force_error: 0.1}}
  - {name: let go, duration: 1, release: [rope]}
faults:
  - {kind: sensor_stuck, member: rope, at: 1.5}
sweep: {stiffness: [100, 200], delay: [0, 0.001], stable_error: 0.2}
)";

std::string message(const std::string& from, const std::string& to) {
  std::string content = kGood;
  const auto at = content.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  content.replace(at, from.size(), to);
  return refusal([&] { parse_scenario(content, "s.yaml"); });
}

TEST(ScenarioReader, ReadsEveryKeyOfAScenario) {
  const Scenario s = parse_scenario(kGood, "s.yaml");
  EXPECT_EQ(s.arms.size(), 2U);
  EXPECT_EQ(s.master, 1);
  EXPECT_NEAR(s.arms[1].turn.z(), M_PI, 1e-12);
  EXPECT_TRUE(s.members[0].pulls_only);
  EXPECT_EQ(s.members[0].law.stiffness, 2450.0);
  EXPECT_EQ(s.phases[0].commands.size(), 2U);
  EXPECT_EQ(s.phases[0].commands[0].over, 1.0);
  EXPECT_EQ(s.phases[0].asked_force_error, 0.1);
  EXPECT_EQ(s.phases[1].commands[0].kind, ScenarioCommand::Kind::kRelease);
  EXPECT_EQ(s.faults[0].member, 0);
  EXPECT_EQ(s.sweep.delay[1], 0.001);
}

// Every key of members, walls and bodies arrives in its own place; what is not given has its default.
TEST(ScenarioReader, ReadsTheObjectsBetweenArms) {
  std::string content = kGood;
  const auto at = content.find("phases:");
  content.insert(at, R"(  - {name: bar, kind: bar, between: [right, left], slack: -0.001, sensor: {rate: 250, delay: 0.001, noise: 0.02, step: 0.05}, law: {kind: tuned}}
  - {name: spring, kind: spring, between: [left, right], stiffness: 800, law: {kind: increment, deadband: 0.1, increment: 0.002, gain: 0.3, proportional: 0.4, damping: 5, feed_forward: 0.6, reach: 0.07, stiffness: 900}}
walls:
  - {name: tissue, arm: right, point: [0.1, 0.2, 0.3], normal: [0, 3, 4], stiffness: 400, stiffening: 50, damping: 2, drag: 8, sensor: {axes: 3, rate: 200}}
  - {name: plain, arm: left, normal: [1, 0, 0], stiffness: 100}
bodies:
  - {name: box, mass: 0.4, inertia: [1e-3, 2e-3, 3e-3], grasps: [{arm: right, stiffness: 5000, damping: 5}, {arm: left, stiffness: 4000}], internal_force: 1.5, impedance: {mass: 2, damping: 40, stiffness: 300, inertia: 0.02, angular_damping: 0.5, angular_stiffness: 6}}
  - {name: ball, mass: 0.1, inertia: [1e-3, 1e-3, 1e-3], grasps: [{arm: left, stiffness: 1000}]}
)");
  const Scenario s = parse_scenario(content, "s.yaml");
  ASSERT_EQ(s.members.size(), 3U);
  const ScenarioMember& rope = s.members[0];
  EXPECT_TRUE(rope.pulls_only);
  EXPECT_EQ(rope.law.kind, ForceLaw::Kind::kProportional);
  EXPECT_EQ(rope.sensor.rate, 500.0);
  EXPECT_EQ(rope.sensor.delay, 0.002);
  const ScenarioMember& bar = s.members[1];
  EXPECT_FALSE(bar.pulls_only);
  EXPECT_EQ(bar.from, 1);
  EXPECT_EQ(bar.to, 0);
  EXPECT_EQ(bar.stiffness, kRigidStiffness);
  EXPECT_EQ(bar.damping, kRigidDamping);
  EXPECT_EQ(bar.slack, -0.001);
  EXPECT_EQ(bar.sensor.noise, 0.02);
  EXPECT_EQ(bar.sensor.step, 0.05);
  EXPECT_TRUE(bar.tuned);
  EXPECT_EQ(bar.law.gain, tuned_force_law(kRigidStiffness, 300.0, 30.0).gain);
  const ScenarioMember& spring = s.members[2];
  EXPECT_FALSE(spring.pulls_only);
  EXPECT_EQ(spring.damping, 0.0);
  EXPECT_EQ(spring.law.kind, ForceLaw::Kind::kIncrement);
  EXPECT_EQ(spring.law.deadband, 0.1);
  EXPECT_EQ(spring.law.increment, 0.002);
  EXPECT_EQ(spring.law.gain, 0.3);
  EXPECT_EQ(spring.law.proportional, 0.4);
  EXPECT_EQ(spring.law.damping, 5.0);
  EXPECT_EQ(spring.law.feed_forward, 0.6);
  EXPECT_EQ(spring.law.reach, 0.07);
  EXPECT_EQ(spring.law.stiffness, 900.0);
  ASSERT_EQ(s.walls.size(), 2U);
  const ScenarioWall& tissue = s.walls[0];
  EXPECT_EQ(tissue.arm, 1);
  EXPECT_EQ(tissue.point, Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_LT((tissue.normal - Eigen::Vector3d(0.0, 0.6, 0.8)).norm(), 1e-15);
  EXPECT_EQ(tissue.stiffness, 400.0);
  EXPECT_EQ(tissue.stiffening, 50.0);
  EXPECT_EQ(tissue.damping, 2.0);
  EXPECT_EQ(tissue.drag, 8.0);
  EXPECT_EQ(tissue.sensor.rate, 200.0);
  EXPECT_EQ(tissue.sensor_axes, 3);
  EXPECT_EQ(s.walls[1].sensor_axes, 1);
  EXPECT_EQ(s.walls[1].drag, 0.0);
  ASSERT_EQ(s.bodies.size(), 2U);
  const ScenarioBody& box = s.bodies[0];
  EXPECT_EQ(box.mass, 0.4);
  EXPECT_EQ(box.inertia, Eigen::Vector3d(1e-3, 2e-3, 3e-3));
  ASSERT_EQ(box.grasps.size(), 2U);
  EXPECT_EQ(box.grasps[0].arm, 1);
  EXPECT_EQ(box.grasps[0].stiffness, 5000.0);
  EXPECT_EQ(box.grasps[0].damping, 5.0);
  EXPECT_EQ(box.grasps[1].damping, 0.0);
  EXPECT_EQ(box.internal_force, 1.5);
  EXPECT_EQ(box.wanted_mass, 2.0);
  EXPECT_EQ(box.impedance_damping, 40.0);
  EXPECT_EQ(box.impedance_stiffness, 300.0);
  EXPECT_EQ(box.wanted_inertia, 0.02);
  EXPECT_EQ(box.angular_damping, 0.5);
  EXPECT_EQ(box.angular_stiffness, 6.0);
  EXPECT_EQ(s.bodies[1].impedance_stiffness, 0.0);
}

// Each message names the place, the found and the expected value.
TEST(ScenarioReader, NamesTheLineOfAnError) {
  const struct {
    const char* from;
    const char* to;
    const char* place;
    const char* words;
  } cases[] = {
      {"veridyn: 1", "veridyn: 2", "s.yaml:1", "veridyn: 1"},
      {"scenario: two slides\n", "", "s.yaml:1", "scenario"},
      {"control: position", "control: positon", "s.yaml:4", "did you mean 'position'"},
      {"frame: tool, start: [0, 0, 0.1], control: position",
       "start: [0, 0, 0.1], control: position", "s.yaml:4", "'frame'"},
      {"start: [0, 0, 0.1], control: position", "start: [0, zero, 0.1], control: position",
       "s.yaml:4", "zero"},
      {"master: right", "master: rigth", "s.yaml:6", "did you mean 'right'"},
      {"name: right", "name: left", "s.yaml:5", "twice"},
      {"between: [left, right]", "between: [left, left]", "s.yaml:8", "the same arm twice"},
      {"between: [left, right]", "between: [left]", "s.yaml:8", "two arms"},
      {"kind: string", "kind: rope", "s.yaml:8", "string"},
      {"stiffness: 2450", "stiffness: -1", "s.yaml:8", "positive"},
      {"gain: 0.1", "gain: -0.1", "s.yaml:8", "below zero"},
      {"rate: 500", "rates: 500", "s.yaml:8", "did you mean 'rate'"},
      {"over: 1", "over: 3", "s.yaml:10", "at most the phase's duration"},
      {"move: [0.01, 0, 0]", "move: [0.01, 0]", "s.yaml:10", "three numbers"},
      {"force: 5", "force: {ropes: 5}", "s.yaml:10", "did you mean 'rope'"},
      {"release: [rope]", "release: [string]", "s.yaml:11", "one of: rope"},
      {"kind: sensor_stuck", "kind: sensor_stick", "s.yaml:13", "sensor_stuck"},
      {"at: 1.5", "at: 0", "s.yaml:13", "positive"},
      {", stable_error: 0.2", "", "s.yaml:14", "stable_error"},
      {"phases:", "phases: [", "s.yaml", "expected a scenario"},
      {"phases:", "control: {damping: [1, -1, 1]}\nphases:", "s.yaml:9", "a damping below zero"},
      {"phases:", "control: {mass: [1, 0, 1]}\nphases:", "s.yaml:9", "three masses above zero"},
      {"phases:", "control: {stiffness: [1, 1, -1]}\nphases:", "s.yaml:9", "three above zero"},
      {"phases:", "control: {rate: 1e-3}\nphases:", "s.yaml:1", "at least one cycle in every phase"},
      {"phases:", "control: {rate: 1e300}\nphases:", "s.yaml:1", "what this machine holds"},
      {"phases:", "control: {torque_delay: 1001}\nphases:", "s.yaml:9", "at most 1000 cycles"},
      {"phases:", "control: {torque_delay: 3e9}\nphases:", "s.yaml:9", "at most 1000 cycles"},
      {"phases:", "control: {torque_delay: 0.5}\nphases:", "s.yaml:9", "a whole number"},
      {"phases:", "control: {torque_delay: -1}\nphases:", "s.yaml:9", "a whole number"},
      {"phases:", "control: {adaptive_friction: true, friction: 0}\nphases:", "s.yaml:9", "'friction' above zero"},
      {"phases:", "seed: 5e9\nphases:", "s.yaml:9", "a whole number"},
      {"phases:", "encoder: fien\nphases:", "s.yaml:9", "one of: "},
      {"phases:", "ask: {largest_force: .nan}\nphases:", "s.yaml:9", "finite number"},
      {"phases:", "walls: [{name: w, arm: left, normal: [0, 0, 0], stiffness: 1}]\nphases:", "s.yaml:9", "a direction"},
      {"phases:", "bodies: [{name: b, mass: 1, inertia: [1, 0, 1], grasps: [{arm: left, stiffness: 1}]}]\nphases:",
       "s.yaml:9", "three numbers above zero"},
      {"phases:", "bodies: [{name: b, mass: 1, inertia: [1, 1, 1], grasps: []}]\nphases:", "s.yaml:9", "at least one"},
      {"phases:", "bodies: [{name: b, mass: 1, inertia: [1, 1, 1], grasps: [{arm: left, stiffness: 1}, {arm: left, "
       "stiffness: 1}]}]\nphases:", "s.yaml:9", "each arm once"},
      {"phases:", "bodies: [{name: b, mass: 1, inertia: [1, 1, 1], grasps: [{arm: left, stiffness: 1}], internal_force: 1, "
       "impedance: {stiffness: 1}}]\nphases:", "s.yaml:9", "an impedance and two grasps"},
      {"phases:", "bodies: [{name: b, mass: 1, inertia: [1, 1, 1], grasps: [{arm: left, stiffness: 1}, {arm: right, "
       "stiffness: 1}], internal_force: 1}]\nphases:", "s.yaml:9", "an impedance and two grasps"},
      {"phases:", "bodies: [{name: b, mass: 1, inertia: [1, 1, 1], grasps: [{arm: left, stiffness: 1}], impedance: {mass: 1}}]\nphases:",
       "s.yaml:9", "'stiffness' here"},
      {"phases:", "walls: [{name: w, arm: left, normal: [1, 0, 0], stiffness: 1, sensor: {axes: 2}}]\nphases:", "s.yaml:9", "one of: 1, 3"},
      {"phases:", "walls: [{name: rope, arm: left, normal: [1, 0, 0], stiffness: 1}]\nphases:", "s.yaml:9", "twice"},
      {"sensor: {rate: 500", "sensor: {axes: 3, rate: 500", "s.yaml:8", "unknown key 'axes'"},
      {"law: {kind: proportional, gain: 0.1}", "law: 1", "s.yaml:8", "a map"},
      {"law: {kind: proportional, gain: 0.1}", "law: {kind: tuned, gain: 0.1}", "s.yaml:8", "unknown key 'gain'"},
      {"law: {kind: proportional, gain: 0.1}", "law: {kind: tunned}", "s.yaml:8", "did you mean 'tuned'"},
      {"law: {kind: proportional, gain: 0.1}", "law: {kind: proportional, reach: 0}", "s.yaml:8", "a positive number"},
      {"delay: 0.002", "delay: 1e305", "s.yaml:8", "samples under way"},
      {"rate: 500", "rate: 1e305", "s.yaml:8", "samples under way"},
      {"start: [0, 0, 0.1], control: position", "start: [0, 0, 1e305], control: position", "s.yaml:4", "expected it within"},
      {"stiffness: [100, 200]", "stiffness: [0, 200]", "s.yaml:14", "a positive number"},
      {"delay: [0, 0.001]", "delay: [-0.1]", "s.yaml:14", "below zero"},
      {"delay: [0, 0.001]", "rate: [0]", "s.yaml:14", "at least one cycle in every phase"},
      {"delay: [0, 0.001]", "rate: [1e305]", "s.yaml:14", "what this machine holds"},
  };
  for (const auto& c : cases) {
    const std::string said = message(c.from, c.to);
    EXPECT_NE(said.find(c.place), std::string::npos) << c.to << ": " << said;
    EXPECT_NE(said.find(c.words), std::string::npos) << c.to << ": " << said;
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
  }
  EXPECT_THROW(read_scenario("no-such.yaml"), InvalidInput);
}

TEST(ScenarioReader, ReadsEveryExample) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(
           std::filesystem::path(VERIDYN_SOURCE_DIR) / "examples/cooperate")) {
    if (entry.path().extension() != ".yaml") continue;
    EXPECT_NO_THROW(read_scenario(entry.path().string())) << entry.path();
    ++count;
  }
  EXPECT_GE(count, 10);
}

// Every member, wall and body has numbers in every cycle: 5000 of them would fill gigabytes.
TEST(ScenarioReader, AcceptsTwoHundredArmsMembersAndBodies) {
  const std::string rope = "  - {name: rope, kind: string, between: [left, right], stiffness: 2450, damping: 2, sensor: {rate: 500, delay: 0.002}, law: {kind: proportional, gain: 0.1}}\n";
  std::string ropes = rope;
  for (int k = 1; k < 200; ++k) ropes += std::string(rope).replace(rope.find("rope"), 4, "rope" + std::to_string(k));
  EXPECT_EQ(message(rope, ropes), "");
  ropes += std::string(rope).replace(rope.find("rope"), 4, "one-more");
  const std::string words = message(rope, ropes);
  EXPECT_NE(words.find("200"), std::string::npos) << words;
  EXPECT_NE(words.find("201 members"), std::string::npos) << words;
  std::string walls = "walls:\n";
  for (int k = 0; k < 201; ++k)
    walls += "  - {name: wall" + std::to_string(k) + ", arm: right, normal: [1, 0, 0], stiffness: 100}\n";
  EXPECT_NE(message("phases:\n", walls + "phases:\n").find("201 walls"), std::string::npos);
}

}  // namespace
}  // namespace veridyn
