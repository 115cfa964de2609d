#include "cooperation/scenario/scenario_parts.hpp"

#include <algorithm>
#include <cmath>

#include "veridyn/math/require.hpp"

namespace veridyn {

void Names::add(const std::string& name, const YamlNode& node) {
  if (std::find(all.begin(), all.end(), name) != all.end())
    node.fail("the " + what + " " + node.found() + " twice", "each name once");
  all.push_back(name);
}

int Names::index(const YamlNode& node) const {
  const std::string name =
      node.word("the name of " + std::string(what == "arm" ? "an " : "a ") + what);
  const auto at = std::find(all.begin(), all.end(), name);
  if (at == all.end())
    node.fail("no " + what + " " + node.found() + did_you_mean(name, all),
              "one of: " + listed(all));
  return static_cast<int>(at - all.begin());
}

void check_arm(const ScenarioArm& arm, const Model& model) {
  require(arm.start.size() == model.joints(), "arm '", arm.name, "': found a start of ",
          arm.start.size(), " joints, expected the ", model.joints(), " of ", model.name(), ".");
  for (int i = 0; i < model.joints(); ++i) {
    const Coordinate& c = model.coordinates()[i];
    require(arm.start[i] >= c.limits.lower && arm.start[i] <= c.limits.upper, "arm '", arm.name,
            "': found joint ", c.name, " at ", arm.start[i], ", expected it within ",
            c.limits.lower, " to ", c.limits.upper, ".");
  }
  std::vector<std::string> frames;
  for (const Frame& frame : model.frames()) frames.push_back(frame.name);
  require(model.find_frame(arm.frame).has_value(), "arm '", arm.name, "': found the frame '", arm.frame,
          "'", did_you_mean(arm.frame, frames), ", expected one of ", model.name(), ": ",
          listed(frames), ".");
}

Eigen::Vector3d read_vector3(const YamlNode& node, const std::string& unit) {
  const std::vector<double> v = node.numbers(3, "three numbers [" + unit + "]");
  return {v[0], v[1], v[2]};
}

double read_positive_or(const YamlNode& node, const std::string& key, double otherwise) {
  const auto value = node.find(key);
  return value ? value->positive_number() : otherwise;
}

double read_nonnegative_or(const YamlNode& node, const std::string& key, double otherwise) {
  const auto value = node.find(key);
  if (!value) return otherwise;
  const double number = value->number();
  if (number < 0.0) value->fail(value->found(), "a number that is not below zero");
  return number;
}

long read_whole_number(const YamlNode& node) {
  const double number = node.number();
  if (number < 0.0 || number > 4e9 || number != std::floor(number))
    node.fail(node.found(), "a whole number that is not below zero");
  return static_cast<long>(number);
}

namespace {

using Kind = ScenarioCommand::Kind;

// Appends wanted forces, {force: {spring: 5, other: 5}} or {force: 5} for all members.
void append_force_commands(const YamlNode& node, const Names& members, double over,
                std::vector<ScenarioCommand>& out) {
  const auto add = [&](int member, const YamlNode& value) {
    ScenarioCommand c;
    c.kind = Kind::kForce;
    c.member = member;
    c.amount = value.number();
    c.over = over;
    out.push_back(c);
  };
  if (!node.is_map()) {
    for (size_t k = 0; k < members.all.size(); ++k) add(static_cast<int>(k), node);
    return;
  }
  for (const YamlNode::Entry& e : node.entries("a force, or one for each member"))
    add(members.index(e.key_node), e.value);
}

// Appends a command of this kind for each listed member.
void append_member_commands(Kind kind, const YamlNode& node, const Names& members,
                     std::vector<ScenarioCommand>& out) {
  for (const YamlNode& item : node.items("a list of members")) {
    ScenarioCommand c;
    c.kind = kind;
    c.member = members.index(item);
    out.push_back(c);
  }
}

ScenarioCommand timed_command(Kind kind, double over) {
  ScenarioCommand c;
  c.kind = kind;
  c.over = over;
  return c;
}

}  // namespace

ScenarioPhase read_phase(const YamlNode& node, const Names& arms, const Names& members) {
  node.allow_keys({"name", "duration", "over", "move", "turn", "tighten", "force", "move_arm",
                   "release", "take", "ask"});
  ScenarioPhase phase;
  phase.name = node.at("name").word("the phase's name");
  phase.duration = node.at("duration").positive_number();
  double over = phase.duration;
  if (const auto given = node.find("over")) {
    over = given->positive_number();
    if (over > phase.duration) given->fail(given->found(), "at most the phase's duration");
  }
  if (const auto list = node.find("release"))
    append_member_commands(Kind::kRelease, *list, members, phase.commands);
  if (const auto list = node.find("take"))
    append_member_commands(Kind::kTake, *list, members, phase.commands);
  if (const auto way = node.find("move")) {
    phase.commands.push_back(timed_command(Kind::kMove, over));
    phase.commands.back().way = read_vector3(*way, "m");
  }
  if (const auto turn = node.find("turn")) {
    phase.commands.push_back(timed_command(Kind::kTurn, over));
    phase.commands.back().way = read_vector3(*turn, "rad");
  }
  if (const auto by = node.find("tighten")) {
    phase.commands.push_back(timed_command(Kind::kTighten, over));
    phase.commands.back().amount = by->number();
  }
  if (const auto ways = node.find("move_arm")) {
    for (const YamlNode::Entry& e : ways->entries("a way for each arm")) {
      phase.commands.push_back(timed_command(Kind::kMoveArm, over));
      phase.commands.back().arm = arms.index(e.key_node);
      phase.commands.back().way = read_vector3(e.value, "m");
    }
  }
  if (const auto force = node.find("force")) append_force_commands(*force, members, over, phase.commands);
  if (const auto ask = node.find("ask")) {
    ask->allow_keys({"force_error", "steady_error", "position_error"});
    phase.asked_position_error = read_nonnegative_or(*ask, "position_error", 0.0);
    phase.asked_force_error = read_nonnegative_or(*ask, "force_error", 0.0);
    phase.asked_steady_error = read_nonnegative_or(*ask, "steady_error", 0.0);
  }
  return phase;
}

ScenarioFault read_fault(const YamlNode& node, const Names& arms, const Names& members) {
  node.allow_keys({"kind", "arm", "member", "at", "by", "reported"});
  using FaultKind = ScenarioFault::Kind;
  ScenarioFault fault;
  fault.kind = read_choice<FaultKind>(node.at("kind"), {{"arm_limp", FaultKind::kArmLimp},
                                                   {"arm_frozen", FaultKind::kArmFrozen},
                                                   {"sensor_stuck", FaultKind::kSensorStuck},
                                                   {"sensor_stale", FaultKind::kSensorStale},
                                                   {"sensor_jump", FaultKind::kSensorJump},
                                                   {"sensor_drift", FaultKind::kSensorDrift}});
  const bool of_arm = fault.kind == FaultKind::kArmLimp || fault.kind == FaultKind::kArmFrozen;
  if (of_arm) {
    fault.arm = arms.index(node.at("arm"));
  } else {
    fault.member = members.index(node.at("member"));
  }
  if (fault.kind == FaultKind::kSensorJump || fault.kind == FaultKind::kSensorDrift)
    fault.by = node.at("by").number();
  fault.at = node.at("at").positive_number();
  if (const auto reported = node.find("reported")) fault.reported = reported->flag();
  return fault;
}

}  // namespace veridyn
