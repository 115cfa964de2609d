#include <algorithm>
#include <fstream>
#include <iterator>

#include "cooperation/scenario/scenario_parts.hpp"
#include "veridyn/cooperation/teleoperation_scenario.hpp"

namespace veridyn {
namespace {

TeleoperationStep read_step(const YamlNode& node, double duration) {
  node.allow_keys({"hand", "over", "clutch"});
  TeleoperationStep step;
  step.over = duration;
  if (const auto way = node.find("hand")) step.way = vector3(*way, "m");
  if (const auto over = node.find("over")) {
    step.over = over->positive_number();
    if (step.over > duration) over->fail(over->found(), "at most the phase's duration");
  }
  if (const auto clutch = node.find("clutch"))
    step.clutch = choice<bool>(*clutch, {{"in", true}, {"out", false}});
  return step;
}

void read_settings(const YamlNode& node, TeleoperationScenario& out) {
  node.allow_keys({"leader", "follower", "scale", "force_scale", "largest_force", "damping", "speed",
                   "hand", "steps"});
  Names arms{"arm", {}};
  for (const ScenarioArm& arm : out.scenario.arms) arms.all.push_back(arm.name);
  out.leader = arms.index(node.at("leader"));
  out.follower = arms.index(node.at("follower"));
  if (out.leader == out.follower)
    node.at("follower").fail("the leader again", "the other arm");
  TeleoperationOptions& o = out.options;
  o.scale = positive_or(node, "scale", o.scale);
  o.force_scale = nonnegative_or(node, "force_scale", o.force_scale);
  o.largest_force = positive_or(node, "largest_force", o.largest_force);
  o.damping = nonnegative_or(node, "damping", o.damping);
  o.speed = positive_or(node, "speed", o.speed);
  o.period = 1.0 / out.scenario.control.rate;
  if (const auto hand = node.find("hand")) {
    hand->allow_keys({"stiffness", "damping"});
    out.hand_stiffness = positive_or(*hand, "stiffness", out.hand_stiffness);
    out.hand_damping = nonnegative_or(*hand, "damping", out.hand_damping);
  }
  out.steps.resize(out.scenario.phases.size());
  const auto steps = node.find("steps");
  if (!steps) return;
  for (const YamlNode::Entry& entry : steps->entries("what the hand does in each phase")) {
    const std::string name = entry.key_node.word("a phase");
    const auto phase = std::find_if(out.scenario.phases.begin(), out.scenario.phases.end(),
                                    [&](const ScenarioPhase& p) { return p.name == name; });
    if (phase == out.scenario.phases.end())
      entry.key_node.fail(entry.key_node.found(), "the name of a phase");
    out.steps[phase - out.scenario.phases.begin()] =
        read_step(entry.value, phase->duration);
  }
}

}  // namespace

bool is_teleoperation(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  while (std::getline(file, line)) {
    if (line.rfind("teleoperation:", 0) == 0) return true;
  }
  return false;
}

TeleoperationScenario read_teleoperation(const std::string& path) {
  TeleoperationScenario out;
  out.scenario = read_scenario(path);
  std::ifstream file(path, std::ios::binary);
  YamlSource source;
  source.file = path;
  source.expected = "a scenario";
  const YamlNode root = YamlNode::parse({std::istreambuf_iterator<char>(file), {}}, source);
  const YamlNode node = root.at("teleoperation");
  if (out.scenario.arms.size() != 2 || !out.scenario.members.empty() ||
      !out.scenario.bodies.empty() || out.scenario.walls.size() > 1)
    node.fail("it beside other things than two arms and at most one wall",
              "a leader, a follower and what it may touch");
  for (const ScenarioPhase& phase : out.scenario.phases) {
    if (!phase.commands.empty()) node.fail("commands in the phases", "names and durations alone");
  }
  read_settings(node, out);
  for (const ScenarioWall& wall : out.scenario.walls) {
    if (wall.arm != out.follower) node.fail("a wall for the leader", "one for the follower");
  }
  return out;
}

}  // namespace veridyn
