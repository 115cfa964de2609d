#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <string>

#include "support/refusal.hpp"
#include "veridyn/cooperation/teleoperation_scenario.hpp"

namespace veridyn {
namespace {

const char* const kLed = R"(veridyn: 1
scenario: one leads
arms:
  - {name: hand, model: psm-3dof, frame: tool, start: [0, 0, 0.1], control: impedance}
  - {name: tool, model: psm-3dof, position: [1, 0, 0], frame: tool, start: [0, 0, 0.1], control: position}
walls:
  - {name: tissue, arm: tool, normal: [0, 0, 1], stiffness: 400}
control: {rate: 500}
phases:
  - {name: free, duration: 2}
  - {name: back, duration: 1.25}
  - {name: still, duration: 3}
teleoperation:
  leader: hand
  follower: tool
  scale: 0.5
  force_scale: 2
  largest_force: 7
  damping: 3
  speed: 0.2
  hand: {stiffness: 200, damping: 4}
  steps:
    free: {hand: [0.03, 0, 0.01], over: 1.5}
    back: {hand: [-0.03, 0, 0], clutch: out}
)";

class TeleoperationReader : public testing::Test {
 protected:
  ~TeleoperationReader() override { std::remove(path_.c_str()); }
  const std::string& write(const std::string& content) const {
    std::ofstream(path_) << content;
    return path_;
  }
  std::string changed(const std::string& from, const std::string& to) const {
    std::string content = kLed;
    const auto at = content.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return at == std::string::npos ? content : content.replace(at, from.size(), to);
  }
  std::string path_ = testing::TempDir() + "veridyn_led_" + std::to_string(::getpid()) + ".yaml";
};

TEST_F(TeleoperationReader, ReadsEveryKey) {
  const TeleoperationScenario s = read_teleoperation(write(kLed));
  EXPECT_EQ(s.leader, 0);
  EXPECT_EQ(s.follower, 1);
  EXPECT_EQ(s.options.scale, 0.5);
  EXPECT_EQ(s.options.force_scale, 2.0);
  EXPECT_EQ(s.options.largest_force, 7.0);
  EXPECT_EQ(s.options.damping, 3.0);
  EXPECT_EQ(s.options.speed, 0.2);
  EXPECT_EQ(s.options.period, 1.0 / 500.0);
  EXPECT_EQ(s.hand_stiffness, 200.0);
  EXPECT_EQ(s.hand_damping, 4.0);
  ASSERT_EQ(s.steps.size(), 3U);
  EXPECT_EQ(s.steps[0].way, Eigen::Vector3d(0.03, 0.0, 0.01));
  EXPECT_EQ(s.steps[0].over, 1.5);
  EXPECT_TRUE(s.steps[0].clutch);
  EXPECT_EQ(s.steps[1].way, Eigen::Vector3d(-0.03, 0.0, 0.0));
  EXPECT_EQ(s.steps[1].over, 1.25);  // the phase's own duration
  EXPECT_FALSE(s.steps[1].clutch);
  EXPECT_EQ(s.steps[2].way, Eigen::Vector3d::Zero());
  EXPECT_TRUE(s.steps[2].clutch);
}

TEST_F(TeleoperationReader, AStepOfTheClutchAloneIsRead) {
  const TeleoperationScenario s = read_teleoperation(write(changed("hand: [-0.03, 0, 0], clutch: out", "clutch: out")));
  EXPECT_EQ(s.steps[1].way.norm(), 0.0);
  EXPECT_FALSE(s.steps[1].clutch);
}

// The hand rests where no steps are given, and the options are those of the header.
TEST_F(TeleoperationReader, MissingKeysHaveTheirDefaults) {
  const std::string whole = kLed;
  const TeleoperationScenario s = read_teleoperation(write(whole.substr(0, whole.find("  scale"))));
  const TeleoperationOptions usual;
  EXPECT_EQ(s.options.scale, usual.scale);
  EXPECT_EQ(s.options.force_scale, usual.force_scale);
  EXPECT_EQ(s.options.largest_force, usual.largest_force);
  EXPECT_EQ(s.hand_stiffness, TeleoperationScenario().hand_stiffness);
  ASSERT_EQ(s.steps.size(), 3U);
  for (const TeleoperationStep& step : s.steps) {
    EXPECT_EQ(step.way.norm(), 0.0);
    EXPECT_TRUE(step.clutch);
  }
}

// However YAML lets the key be written; not where the word is no key of the file.
TEST_F(TeleoperationReader, TeleoperationFilesAreRecognisedByTheirKey) {
  for (const char* key : {"teleoperation:", "\"teleoperation\":", "teleoperation :", "? teleoperation\n:"})
    EXPECT_TRUE(is_teleoperation(write(changed("teleoperation:", key)))) << key;
  EXPECT_TRUE(is_teleoperation(write("{teleoperation: {leader: a}}")));
  EXPECT_FALSE(is_teleoperation(write(changed("teleoperation:", "# teleoperation:\nsource:"))));
  EXPECT_FALSE(is_teleoperation(write("a: |\n teleoperation: 1\nb: 2")));
  for (const char* none : {"teleoperation: [", "- teleoperation: 1", "", "teleoperation"})
    EXPECT_FALSE(is_teleoperation(write(none))) << none;
  EXPECT_FALSE(is_teleoperation("/no/such/file"));
}

TEST_F(TeleoperationReader, NamesTheLineOfAnError) {
  const struct {
    const char* from;
    const char* to;
    const char* place;
    const char* words;
  } cases[] = {
      {"  leader: hand\n", "", ":14:", "'leader' here"},
      {"follower: tool", "follower: hand", ":15:", "found the leader again, expected the other arm"},
      {"follower: tool", "follower: tol", ":15:", "did you mean 'tool'"},
      {"scale: 0.5", "scale: 0", ":16:", "a positive number"},
      {"force_scale: 2", "force_scale: -1", ":17:", "below zero"},
      {"largest_force: 7", "largest_force: 0", ":18:", "a positive number"},
      {"damping: 3", "damping: -3", ":19:", "below zero"},
      {"speed: 0.2", "speed: .nan", ":20:", "finite number"},
      {"hand: {stiffness: 200", "hand: {stiffness: 0", ":21:", "a positive number"},
      {"damping: 4", "dumping: 4", ":21:", "did you mean 'damping'"},
      {"over: 1.5", "over: 2.5", ":23:", "at most the phase's duration"},
      {"over: 1.5", "over: 0", ":23:", "a positive number"},
      {"[0.03, 0, 0.01]", "[0.03, 0]", ":23:", "three numbers"},
      {"clutch: out", "clutch: off", ":24:", "one of: in, out"},
      {"clutch: out", "move: [1, 0, 0]", ":24:", "unknown key 'move'"},
      {"    back: {", "    bak: {", ":24:", "the name of one phase"},
      {"{name: still", "{name: back", ":24:", "the name of one phase"},
      {"arm: tool, normal", "arm: hand, normal", ":14:", "found a wall for the leader"},
      {"control: {", "  - {name: other, arm: tool, normal: [1, 0, 0], stiffness: 1}\ncontrol: {", ":15:", "at most one wall"},
      {"control: {", "members: [{name: rope, kind: string, between: [hand, tool], stiffness: 1, law: {kind: tuned}}]\ncontrol: {",
       ":15:", "a leader, a follower"},
      {"control: {", "bodies: [{name: b, mass: 1, inertia: [1, 1, 1], grasps: [{arm: tool, stiffness: 1}]}]\ncontrol: {", ":15:",
       "a leader, a follower"},
      {"walls:", "  - {name: third, model: psm-3dof, frame: tool, start: [0, 0, 0.1], control: position}\nwalls:", ":15:",
       "two arms"},
      {"{name: free, duration: 2}", "{name: free, duration: 2, move: [0, 0, 0.1]}", ":14:", "commands in the phases"},
      {"{name: free, duration: 2}", "{name: free, duration: 2, ask: {force_error: 1}}", ":10:", "a bound of the phase 'free'"},
      {"{name: free, duration: 2}", "{name: free, duration: 2, ask: {steady_error: 1}}", ":10:", "a bound of the phase 'free'"},
      {"{name: free, duration: 2}", "{name: free, duration: 2, ask: {position_error: 1}}", ":10:", "a bound of the phase 'free'"},
      {"control: {", "ask: {largest_force: 3}\ncontrol: {", ":8:", "a bound of the run"},
      {"control: {", "faults: [{kind: arm_limp, arm: tool, at: 1}]\ncontrol: {", ":8:", "--board-fault"},
  };
  for (const auto& c : cases) {
    const std::string& path = write(changed(c.from, c.to));
    const std::string said = refusal([&] { read_teleoperation(path); });
    EXPECT_EQ(said.find(path + c.place), 0U) << c.to << ": " << said;
    EXPECT_NE(said.find(c.words), std::string::npos) << c.to << ": " << said;
  }
  const std::string whole = kLed;
  const std::string& path = write(whole.substr(0, whole.find("teleoperation:")));
  EXPECT_TRUE(refuses_with("'teleoperation' here", [&] { read_teleoperation(path); }));
}

}  // namespace
}  // namespace veridyn
