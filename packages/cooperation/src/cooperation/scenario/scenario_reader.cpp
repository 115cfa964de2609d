#include <algorithm>
#include <cmath>
#include <filesystem>

#include "veridyn/files/input_file.hpp"
#include "veridyn/math/random_numbers.hpp"
#include "veridyn/files/yaml/yaml_node.hpp"
#include "cooperation/scenario/scenario_objects.hpp"
#include "cooperation/scenario/scenario_parts.hpp"
#include "veridyn/cooperation/scenario.hpp"
#include "veridyn/math/most_rows.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/model/suggestion.hpp"
#include "veridyn/simulation/sensor_noise.hpp"

namespace veridyn {
namespace {

namespace fs = std::filesystem;

// A model given by a path is searched for next to the scenario; a bare name is that of a robot of the tool.
std::string model_path(const std::string& named, const std::string& scenario) {
  const bool is_file = named.find('/') != std::string::npos || fs::path(named).has_extension();
  if (!is_file || fs::path(named).is_absolute()) return named;
  return (fs::path(scenario).parent_path() / named).string();
}

// Each element has numbers in every row of the run, and states in dense matrices of the stability analysis.
constexpr std::size_t kMostElements = 200;

// Items of a list; fails if there are more than 200.
std::vector<YamlNode> bounded_list(const YamlNode& list, const std::string& what) {
  std::vector<YamlNode> out = list.items("a list of " + what);
  if (out.size() > kMostElements) list.fail(text(out.size(), " ", what), text("at most ", kMostElements));
  return out;
}

ScenarioArm read_arm(const YamlNode& node, const std::string& scenario) {
  node.allow_keys(
      {"name", "model", "seed", "position", "turn", "frame", "offset", "start", "control",
       "calibration_error", "controller_model"});
  ScenarioArm arm;
  arm.name = node.at("name").word("the arm's name");
  arm.model = model_path(node.at("model").word("a robot"), scenario);
  if (const auto seed = node.find("seed")) arm.seed = static_cast<unsigned>(read_whole_number(*seed));
  if (const auto position = node.find("position")) arm.position = read_vector3(*position, "m");
  if (const auto turn = node.find("turn")) arm.turn = read_vector3(*turn, "rad");
  if (const auto offset = node.find("offset")) arm.offset = read_vector3(*offset, "m");
  if (const auto error = node.find("calibration_error")) {
    error->allow_keys({"position", "turn"});
    if (const auto by = error->find("position")) arm.calibration_position = read_vector3(*by, "m");
    if (const auto by = error->find("turn")) arm.calibration_turn = read_vector3(*by, "rad");
  }
  if (const auto model = node.find("controller_model"))
    arm.controller_model = model_path(model->word("a robot"), scenario);
  arm.frame = node.at("frame").word("the frame that holds the object");
  const std::vector<YamlNode> start = node.at("start").items("a list of joint positions");
  arm.start = VectorXd(static_cast<Eigen::Index>(start.size()));
  for (size_t i = 0; i < start.size(); ++i)
    arm.start[static_cast<Eigen::Index>(i)] = start[i].number();
  const YamlNode control = node.at("control");
  arm.control = read_choice<ArmControl>(
      control, {{"position", ArmControl::kPosition}, {"impedance", ArmControl::kImpedance}});
  try {
    check_arm(arm, read_model(arm.model));
    if (!arm.controller_model.empty()) check_arm(arm, read_model(arm.controller_model));
  } catch (const InvalidInput& error) {
    throw InvalidInput(text(node.where(), ": ", error.what()));
  }
  return arm;
}

ScenarioControl read_control(const YamlNode& node) {
  node.allow_keys({"rate", "position_frequency", "mass", "damping", "stiffness", "friction",
                   "observer", "velocity_cutoff", "largest_force", "largest_force_error",
                   "largest_error", "largest_age", "stuck_force", "jump_force", "drift_force", "friction_rule",
                   "adaptive_friction", "force_cutoff", "motor_lag", "torque_delay", "guard", "largest_energy", "relief_force"});
  ScenarioControl c;
  c.rate = read_positive_or(node, "rate", c.rate);
  c.position_frequency = read_positive_or(node, "position_frequency", c.position_frequency);
  if (const auto mass = node.find("mass")) c.mass = read_vector3(*mass, "kg");
  if (const auto damping = node.find("damping")) c.damping = read_vector3(*damping, "N s/m");
  if (const auto stiffness = node.find("stiffness")) c.stiffness = read_vector3(*stiffness, "N/m");
  if (c.mass.minCoeff() <= 0.0)
    node.at("mass").fail("a mass that is not above zero", "three masses above zero [kg]");
  if (c.stiffness.minCoeff() <= 0.0)
    node.at("stiffness").fail("a stiffness that is not above zero", "three above zero [N/m]");
  if (c.damping.minCoeff() < 0.0)
    node.at("damping").fail("a damping below zero", "three numbers that are not below zero [N s/m]");
  c.friction = read_nonnegative_or(node, "friction", c.friction);
  c.observer = read_nonnegative_or(node, "observer", c.observer);
  if (const auto rule = node.find("friction_rule"))
    c.friction_rule = read_choice<FrictionRule>(*rule, {{"velocity", FrictionRule::kVelocity},
                                                   {"stick-slip", FrictionRule::kStickSlip},
                                                   {"presliding", FrictionRule::kPresliding}});
  if (const auto adaptive = node.find("adaptive_friction")) c.adaptive_friction = adaptive->flag();
  if (c.adaptive_friction && !(c.friction > 0.0))
    node.at("adaptive_friction").fail("it without friction compensation", "'friction' above zero");
  c.force_cutoff = read_nonnegative_or(node, "force_cutoff", c.force_cutoff);
  c.motor_lag = read_nonnegative_or(node, "motor_lag", c.motor_lag);
  if (const auto delay = node.find("torque_delay")) {
    const long cycles = read_whole_number(*delay);
    if (cycles > kLongestTorqueDelay) delay->fail(delay->found(), text("at most ", kLongestTorqueDelay, " cycles"));
    c.torque_delay = static_cast<int>(cycles);
  }
  c.largest_energy = read_nonnegative_or(node, "largest_energy", c.largest_energy);
  c.relief_force = read_positive_or(node, "relief_force", c.relief_force);
  if (const auto guard = node.find("guard")) c.guard = guard->flag();
  c.velocity_cutoff = read_positive_or(node, "velocity_cutoff", c.velocity_cutoff);
  c.largest_force = read_positive_or(node, "largest_force", c.largest_force);
  c.largest_force_error = read_positive_or(node, "largest_force_error", c.largest_force_error);
  c.largest_error = read_positive_or(node, "largest_error", c.largest_error);
  c.largest_age = read_positive_or(node, "largest_age", c.largest_age);
  c.stuck_force = read_positive_or(node, "stuck_force", c.stuck_force);
  c.jump_force = read_positive_or(node, "jump_force", c.jump_force);
  c.drift_force = read_positive_or(node, "drift_force", c.drift_force);
  return c;
}

// Values of a grid, not below zero; empty if the key is missing.
std::vector<double> read_grid(const YamlNode& node, const std::string& key) {
  std::vector<double> values;
  const auto list = node.find(key);
  if (!list) return values;
  for (const YamlNode& item : list->items("a list of numbers")) {
    values.push_back(item.number());
    if (values.back() < 0.0) item.fail(item.found(), "a number that is not below zero");
    if (key == "stiffness" && values.back() == 0.0) item.fail(item.found(), "a positive number");
  }
  return values;
}

ScenarioSweep read_sweep(const YamlNode& node) {
  node.allow_keys({"stiffness", "delay", "rate", "stable_error"});
  ScenarioSweep sweep;
  sweep.stiffness = read_grid(node, "stiffness");
  sweep.delay = read_grid(node, "delay");
  sweep.rate = read_grid(node, "rate");
  sweep.stable_error = node.at("stable_error").positive_number();
  return sweep;
}

// Draws calibration errors between the bases: every arm but the leader is displaced from its assumed
// position, in a direction that depends on the seed.
void draw_base_errors(const YamlNode& error, Scenario& s) {
  error.allow_keys({"position", "turn"});
  const double metres = read_nonnegative_or(error, "position", 0.0);
  const double radians = read_nonnegative_or(error, "turn", 0.0);
  RandomNumbers random(s.seed, 78);
  const auto direction = [&random] {
    Eigen::Vector3d v;
    for (double& c : v) c = random.normal();
    return Eigen::Vector3d(v.normalized());
  };
  for (std::size_t k = 0; k < s.arms.size(); ++k) {
    const Eigen::Vector3d shift = metres * direction();
    const Eigen::Vector3d turn = radians * direction();
    if (static_cast<int>(k) == s.master) continue;
    s.arms[k].calibration_position += shift;
    s.arms[k].calibration_turn += turn;
  }
}

// Fails if a phase does not have a single cycle at this rate [Hz], or if the recorded data would not fit into
// memory.
void require_memory(const Scenario& s, double rate, const YamlNode& node) {
  double seconds = 0.0;
  for (const ScenarioPhase& phase : s.phases) {
    seconds += phase.duration;
    if (phase.duration * rate < 1.0)
      node.fail(text("a rate of ", rate, " Hz for the ", phase.duration, " s of '", phase.name, "'"),
                "at least one cycle in every phase");
  }
  double numbers = 1.0 + 6.0 * static_cast<double>(s.members.size() + s.walls.size() + s.bodies.size());
  for (const ScenarioArm& arm : s.arms) numbers += 3.0 * static_cast<double>(arm.start.size() + 3);
  const double most = std::floor(most_rows(numbers));
  if (seconds * rate < most) return;
  node.fail(text(seconds, " s at ", rate, " Hz in all"),
            text("fewer than ", most, " cycles, what this machine holds"));
}

// Reads the whole scenario; fails at the node with a mistake.
Scenario read_root(const YamlNode& root, const std::string& path) {
  if (!root.is_map() || !root.find("scenario"))
    root.fail("no key 'scenario'",
              "a scenario, which begins with 'veridyn: 1' and 'scenario: NAME'");
  const auto version = root.find("veridyn");
  if (!version || version->number() != 1.0) root.fail("no 'veridyn: 1'", "it at the top");
  root.allow_keys({"veridyn", "scenario", "source", "seed", "model_error", "encoder", "arms",
                   "leader", "master", "members", "walls", "bodies", "control", "phases", "faults", "sweep",
                   "ask", "base_pose_error", "teleoperation"});
  Scenario s;
  s.name = root.at("scenario").word("the scenario's name");
  if (const auto source = root.find("source")) s.source = source->word("where it comes from");
  if (const auto seed = root.find("seed")) s.seed = static_cast<unsigned>(read_whole_number(*seed));
  s.model_error = read_nonnegative_or(root, "model_error", 0.0);
  if (const auto encoder = root.find("encoder")) {
    s.encoder = encoder->word("a noise preset");
    const std::vector<std::string>& known = sensor_noise_names();
    if (std::find(known.begin(), known.end(), s.encoder) == known.end())
      encoder->fail(encoder->found(), "one of: " + listed(known));
  }
  Names arms{"arm", {}};
  for (const YamlNode& node : root.at("arms").items("a list of arms")) {
    s.arms.push_back(read_arm(node, path));
    arms.add(s.arms.back().name, node.at("name"));
  }
  if (s.arms.empty() || s.arms.size() > 8)
    root.at("arms").fail(root.at("arms").found(), "1 to 8 arms");
  for (const char* key : {"master", "leader"}) {  // "master" is the word of earlier versions
    if (const auto leader = root.find(key)) s.master = arms.index(*leader);
  }
  if (const auto error = root.find("base_pose_error")) draw_base_errors(*error, s);
  Names members{"member", {}};
  if (const auto list = root.find("members")) {
    for (const YamlNode& node : bounded_list(*list, "members")) {
      s.members.push_back(read_member(node, arms));
      members.add(s.members.back().name, node.at("name"));
    }
  }
  if (const auto list = root.find("walls")) {
    for (const YamlNode& node : bounded_list(*list, "walls")) {
      s.walls.push_back(read_wall(node, arms));
      members.add(s.walls.back().name, node.at("name"));
    }
    members.all.resize(s.members.size());
  }
  if (const auto list = root.find("bodies")) {
    for (const YamlNode& node : bounded_list(*list, "bodies"))
      s.bodies.push_back(read_body(node, arms));
  }
  if (const auto ask = root.find("ask")) {
    ask->allow_keys({"largest_force"});
    s.asked_largest_force = ask->at("largest_force").positive_number();
  }
  if (const auto control = root.find("control")) s.control = read_control(*control);
  tune_force_laws(s);
  for (const YamlNode& node : root.at("phases").items("a list of phases"))
    s.phases.push_back(read_phase(node, arms, members));
  if (s.phases.empty()) root.at("phases").fail("no phases", "at least one");
  require_memory(s, s.control.rate, root.at("phases"));
  if (const auto faults = root.find("faults")) {
    for (const YamlNode& node : faults->items("a list of faults"))
      s.faults.push_back(read_fault(node, arms, members));
  }
  if (const auto sweep = root.find("sweep")) {
    s.sweep = read_sweep(*sweep);
    for (const double rate : s.sweep.rate) require_memory(s, rate, *sweep);
  }
  return s;
}

}  // namespace

void tune_force_laws(Scenario& scenario) {
  const ScenarioControl& c = scenario.control;
  for (ScenarioMember& m : scenario.members) {
    if (m.tuned) m.law = tuned_force_law(m.stiffness, c.stiffness.mean(), c.damping.mean());
  }
}

Scenario parse_scenario(const std::string& content, const std::string& path) {
  YamlSource source;
  source.file = path;
  source.expected = "a scenario";
  return read_root(YamlNode::parse(content, source), path);
}

Scenario read_scenario(const std::string& path) {
  return parse_scenario(content_of_file(path, "a scenario (YAML)"), path);
}

}  // namespace veridyn
