#include <algorithm>

#include "cooperation/scenario/scenario_parts.hpp"
#include "veridyn/files/input_file.hpp"
#include "veridyn/cooperation/teleoperation_scenario.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

TeleoperationStep read_step(const YamlNode& node, double duration) {
  node.allow_keys({"hand", "over", "clutch"});
  TeleoperationStep step;
  step.over = duration;
  if (const auto way = node.find("hand")) step.way = read_vector3(*way, "m");
  if (const auto over = node.find("over")) {
    step.over = over->positive_number();
    if (step.over > duration) over->fail(over->found(), "at most the phase's duration");
  }
  if (const auto clutch = node.find("clutch"))
    step.clutch = read_choice<bool>(*clutch, {{"in", true}, {"out", false}});
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
  o.scale = read_positive_or(node, "scale", o.scale);
  o.force_scale = read_nonnegative_or(node, "force_scale", o.force_scale);
  o.largest_force = read_positive_or(node, "largest_force", o.largest_force);
  o.damping = read_nonnegative_or(node, "damping", o.damping);
  o.speed = read_positive_or(node, "speed", o.speed);
  o.period = 1.0 / out.scenario.control.rate;
  if (const auto hand = node.find("hand")) {
    hand->allow_keys({"stiffness", "damping"});
    out.hand_stiffness = read_positive_or(*hand, "stiffness", out.hand_stiffness);
    out.hand_damping = read_nonnegative_or(*hand, "damping", out.hand_damping);
  }
  out.steps.resize(out.scenario.phases.size());
  const auto steps = node.find("steps");
  if (!steps) return;
  for (const YamlNode::Entry& entry : steps->entries("what the hand does in each phase")) {
    const std::string name = entry.key_node.word("a phase");
    const auto has_name = [&](const ScenarioPhase& p) { return p.name == name; };
    const auto phase = std::find_if(out.scenario.phases.begin(), out.scenario.phases.end(), has_name);
    if (phase == out.scenario.phases.end() || std::any_of(phase + 1, out.scenario.phases.end(), has_name))
      entry.key_node.fail(entry.key_node.found(), "the name of one phase");
    out.steps[phase - out.scenario.phases.begin()] =
        read_step(entry.value, phase->duration);
  }
}

// These keys have no effect here: bounds would count as met, and faults would not occur.
void refuse_unused_keys(const YamlNode& root, const Scenario& scenario) {
  const auto ask = root.find("ask");
  if (ask) ask->fail("a bound of the run beside 'teleoperation'", "none: its report tells what was reached");
  const auto faults = root.find("faults");
  if (faults) faults->fail("faults beside 'teleoperation'", "none: --board-fault lets boards fail");
  for (const ScenarioPhase& phase : scenario.phases) {
    if (phase.asked_force_error > 0.0 || phase.asked_steady_error > 0.0 || phase.asked_position_error > 0.0)
      root.at("phases").fail(text("a bound of the phase '", phase.name, "' beside 'teleoperation'"), "none: its report tells what was reached");
  }
}

}  // namespace

bool is_teleoperation(const std::string& path) {
  try {
    YamlSource source;
    return YamlNode::parse(content_of_file(path, "a scenario (YAML)"), source).find("teleoperation").has_value();
  } catch (const InvalidInput&) {
    return false;
  }
}

TeleoperationScenario read_teleoperation(const std::string& path) {
  YamlSource source;
  source.file = path;
  source.expected = "a scenario";
  const std::string content = content_of_file(path, "a scenario (YAML)");
  TeleoperationScenario out;
  out.scenario = parse_scenario(content, path);
  const YamlNode root = YamlNode::parse(content, source);
  const YamlNode node = root.at("teleoperation");
  if (out.scenario.arms.size() != 2 || !out.scenario.members.empty() ||
      !out.scenario.bodies.empty() || out.scenario.walls.size() > 1)
    node.fail("it beside other things than two arms and at most one wall",
              "a leader, a follower and what it may touch");
  for (const ScenarioPhase& phase : out.scenario.phases) {
    if (!phase.commands.empty()) node.fail("commands in the phases", "names and durations alone");
  }
  refuse_unused_keys(root, out.scenario);
  read_settings(node, out);
  for (const ScenarioWall& wall : out.scenario.walls) {
    if (wall.arm != out.follower) node.fail("a wall for the leader", "one for the follower");
  }
  return out;
}

}  // namespace veridyn
