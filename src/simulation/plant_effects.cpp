#include <algorithm>
#include <cmath>
#include <utility>

#include "effect_sizes.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/kinematics/motion_limits.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/math/vector3.hpp"
#include "veridyn/model/model_file.hpp"
#include "model/suggestion.hpp"
#include "veridyn/simulation/hidden_effect.hpp"

namespace veridyn {
namespace {

std::vector<std::string> coordinate_names(const Model& arm) {
  std::vector<std::string> names;
  for (const Coordinate& c : arm.coordinates()) names.push_back(c.name);
  return names;
}

int find_joint(const Model& arm, const HiddenEffect& hidden, const std::string& word) {
  int joint = arm.find_coordinate(word);
  if (joint < 0 && !word.empty() && word.size() < 4 &&
      std::all_of(word.begin(), word.end(), [](char c) { return c >= '0' && c <= '9'; })) {
    joint = std::stoi(word) - 1;
  }
  const std::vector<std::string> names = coordinate_names(arm);
  require(joint >= 0 && joint < arm.joints(), "effect '", hidden.asked, "': found the joint '",
          word, "'", did_you_mean(word, names), ", expected a number from 1 to ", arm.joints(),
          " or one of: ", listed(names), ".");
  return joint;
}

// The value of a key, or its default; every key that is asked for is known.
using Defaults = std::vector<std::pair<std::string, double>>;

std::map<std::string, double> filled(const HiddenEffect& hidden, const Defaults& defaults) {
  std::vector<std::string> keys;
  std::map<std::string, double> values;
  for (const auto& [key, value] : defaults) {
    keys.push_back(key);
    values[key] = value;
  }
  require(hidden.from.empty(), "effect '", hidden.asked,
          "': found the key 'from', expected one of: ", listed(keys), ".");
  for (const auto& [key, value] : hidden.values) {
    require(values.count(key) != 0, "effect '", hidden.asked, "': found the key '", key, "'",
            did_you_mean(key, keys), ", expected one of: ", listed(keys), ".");
    values[key] = value;
  }
  return values;
}

// Puts one effect after the other into the description.
class Planter {
 public:
  explicit Planter(const Model& arm)
      : out_{arm,
             {},
             VectorXd::Ones(arm.joints()),
             VectorXd::Zero(arm.joints()),
             VectorXd::Zero(arm.joints()),
             {}},
        effort_(standard_effort(arm)) {
    for (int i = 0; i < arm.joints(); ++i) {
      const RecordedChannel& recorded = arm.coordinates()[static_cast<size_t>(i)].recorded;
      out_.torque_gain[i] = recorded.torque_gain;
      out_.torque_delay[i] = recorded.torque_delay;
      out_.encoder_offset[i] = recorded.position_offset;
    }
  }

  void plant(const HiddenEffect& hidden) {
    if (hidden.effect == "payload") return plant_payload(hidden);
    if (hidden.effect == "gravity_tilt") return plant_tilt(hidden);
    if (hidden.effect == "coupling_error") return plant_constant(hidden);
    if (hidden.effect == "torque_gain") return plant_signal(hidden, "gain", 1.05, out_.torque_gain);
    if (hidden.effect == "time_delay")
      return plant_signal(hidden, "seconds", 0.004, out_.torque_delay);
    const int joint = find_joint(out_.arm, hidden, hidden.place);
    if (hidden.effect == "encoder_offset") {
      const bool slides = out_.arm.coordinates()[static_cast<size_t>(joint)].prismatic;
      return plant_signal(hidden, "offset", slides ? 0.001 : 0.01, out_.encoder_offset);
    }
    if (hidden.effect == "external_contact") return plant_contact(hidden, joint);
    plant_term(hidden, joint);
  }

  PlantedArm finish() && {
    // Terms stand at the end of the model's effects, in the order in which they were asked for.
    size_t term = out_.arm.effects().size() - terms_.size();
    const Model sized = with_sensible_effects(out_.arm);
    for (const size_t planted : terms_) {
      require(was_given(term) || has_force(sized.effects()[term]), "effect '", asked_[planted],
              "': found no sensible size for it on this arm, expected its parameters.");
      out_.effects[planted].values = sized.effects()[term].values;
      ++term;
    }
    out_.arm = sized;
    return std::move(out_);
  }

 private:
  void add(const HiddenEffect& hidden, std::string place, int joint,
           std::map<std::string, double> values) {
    out_.effects.push_back({hidden.effect, std::move(place), joint, std::move(values)});
    asked_.push_back(hidden.asked);
  }

  void plant_signal(const HiddenEffect& hidden, const std::string& key, double initial,
                    VectorXd& target) {
    const int joint = find_joint(out_.arm, hidden, hidden.place);
    auto values = filled(hidden, {{key, initial}});
    require(key != "seconds" || values[key] >= 0.0, "effect '", hidden.asked,
            "': found a delay of ", values[key], " s, expected none below zero.");
    target[joint] = values[key];
    add(hidden, out_.arm.coordinates()[static_cast<size_t>(joint)].name, joint + 1,
        std::move(values));
  }

  void plant_contact(const HiddenEffect& hidden, int joint) {
    auto v = filled(hidden, {{"from", 5.0}, {"to", 7.0}, {"effort", 0.5 * effort_[joint]}});
    require(v["from"] < v["to"], "effect '", hidden.asked, "': found a contact from ", v["from"],
            " s to ", v["to"], " s, expected it to end after it begins.");
    out_.contacts.push_back({joint, v["from"], v["to"], v["effort"]});
    add(hidden, out_.arm.coordinates()[static_cast<size_t>(joint)].name, joint + 1, std::move(v));
  }

  void plant_payload(const HiddenEffect& hidden) {
    ModelDescription arm = out_.arm.description();
    std::vector<std::string> names;
    for (const Frame& frame : arm.frames) names.push_back(frame.name);
    const int k = out_.arm.find_frame(hidden.place);
    require(k >= 0, "effect '", hidden.asked, "': found the frame '", hidden.place, "'",
            did_you_mean(hidden.place, names), ", expected one of: ", listed(names), ".");
    const VectorXd phi = *out_.arm.inertial_values();
    const auto bodies = static_cast<Eigen::Index>(out_.arm.bodies().size());
    double mass = 0.0;
    for (Eigen::Index b = 0; b < bodies; ++b)
      mass += phi[b * kBodyParameters] / static_cast<double>(bodies);
    auto v = filled(hidden, {{"mass", 0.1 * mass}, {"x", 0.0}, {"y", 0.0}, {"z", 0.0}});
    require(v["mass"] > 0.0, "effect '", hidden.asked, "': found a mass of ", v["mass"],
            " kg, expected a positive one.");
    const Eigen::Vector3d place(v["x"], v["y"], v["z"]);
    const InertialParameters load =
        inertial_parameters(v["mass"], place, Eigen::Matrix<double, 6, 1>::Zero());
    std::optional<Body>& body = arm.frames[static_cast<size_t>(k)].body;
    if (!body) {
      body = Body{};
      body->phi = InertialParameters::Zero();
      body->fixed = true;
    }
    *body->phi += load;
    out_.arm = Model(std::move(arm));
    add(hidden, hidden.place, 0, std::move(v));
  }

  void plant_tilt(const HiddenEffect& hidden) {
    auto v = filled(hidden, {{"roll", 0.03}, {"pitch", 0.02}});
    ModelDescription arm = out_.arm.description();
    const Mat3d R_world_base = rotation_y(v["pitch"]) * rotation_x(v["roll"]);
    const Vec3d g =
        rotate_back(R_world_base, Vec3d{arm.gravity.x(), arm.gravity.y(), arm.gravity.z()});
    arm.gravity = {g.x, g.y, g.z};
    out_.arm = Model(std::move(arm));
    add(hidden, "arm", 0, std::move(v));
  }

  void plant_constant(const HiddenEffect& hidden) {
    const auto& constants = out_.arm.description().constants;
    std::vector<std::string> names;
    for (const auto& [name, value] : constants) names.push_back(name);
    const auto constant = constants.find(hidden.place);
    require(constant != constants.end(), "effect '", hidden.asked, "': found '", hidden.place, "'",
            did_you_mean(hidden.place, names), ", expected a constant of the robot file, one of: ",
            names.empty() ? "(it has none)" : listed(names), ".");
    const double size = constant->second != 0.0 ? 0.1 * constant->second : 0.05;
    auto v = filled(hidden, {{"change", size}});
    ModelFileOptions options;
    options.constants[hidden.place] = constant->second + v["change"];
    out_.arm = read_yaml(to_yaml(out_.arm), out_.arm.name(), options);
    add(hidden, hidden.place, 0, std::move(v));
  }

  void plant_term(const HiddenEffect& hidden, int joint) {
    require(has_effect(hidden.effect), "effect '", hidden.asked, "': found '", hidden.effect,
            "', which cannot be simulated yet, expected one of: ", listed(simulated_names()), ".");
    EffectTerm term;
    term.effect = hidden.effect;
    term.axis.coefficients = VectorXd::Unit(out_.arm.joints(), joint);
    term.values = hidden.values;
    const Effect& effect = find_effect(hidden.effect);
    std::vector<std::string> keys;
    for (const EffectParameter& p : effect.parameters()) keys.push_back(p.name);
    for (const EffectShape& s : effect.shapes()) {
      keys.push_back(s.name);
    }
    if (effect.needs_source()) {
      keys.emplace_back("from");
      require(!hidden.from.empty(), "effect '", hidden.asked,
              "': found no source, expected from=JOINT.");
      term.from =
          Axis{VectorXd::Unit(out_.arm.joints(), find_joint(out_.arm, hidden, hidden.from)), 0.0};
    }
    const std::string extra =
        !hidden.from.empty() && !effect.needs_source() ? "from" : unknown_key(hidden, keys);
    require(extra.empty(), "effect '", hidden.asked, "': found the key '", extra, "'",
            did_you_mean(extra, keys), ", expected one of: ", listed(keys), ".");
    fill_shapes(effect, joint, term);
    ModelDescription arm = out_.arm.description();
    arm.effects.push_back(std::move(term));
    out_.arm = Model(std::move(arm));
    terms_.push_back(out_.effects.size());
    add(hidden, out_.arm.coordinates()[static_cast<size_t>(joint)].name, joint + 1, {});
  }

  // Shape constants that are not given: the effect's own; a range that it wants from its caller is
  // the joint's.
  void fill_shapes(const Effect& effect, int joint, EffectTerm& term) const {
    const MotionLimits limits = motion_limits(out_.arm);
    const ShapeValues initial = BoundEffect(out_.arm, term).shape();
    const std::vector<EffectShape> shapes = effect.shapes();
    for (size_t k = 0; k < shapes.size(); ++k) {
      double value = initial[k];
      if (shapes[k].name == "centre") value = 0.5 * (limits.lower[joint] + limits.upper[joint]);
      if (shapes[k].name == "half_range") value = 0.5 * (limits.upper[joint] - limits.lower[joint]);
      const bool can_stand_in_files = value > 0.0 || !shapes[k].logarithmic;
      if (can_stand_in_files) term.values.emplace(shapes[k].name, value);
    }
  }

  // True if the request had all parameters of a term.
  bool was_given(size_t term) const {
    return BoundEffect(out_.arm, out_.arm.effects()[term]).has_values();
  }

  static bool has_force(const EffectTerm& term) {
    for (const EffectParameter& p : find_effect(term.effect).parameters()) {
      if (term.values.at(p.name) != 0.0) return true;
    }
    return false;
  }

  static std::string unknown_key(const HiddenEffect& hidden, const std::vector<std::string>& keys) {
    for (const auto& [key, value] : hidden.values) {
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) return key;
    }
    return "";
  }

  static std::vector<std::string> simulated_names() {
    std::vector<std::string> names{"payload",    "gravity_tilt",   "coupling_error",  "torque_gain",
                                   "time_delay", "encoder_offset", "external_contact"};
    for (const Effect* effect : all_effects()) names.push_back(effect->name());
    return names;
  }

  PlantedArm out_;
  VectorXd effort_;
  std::vector<std::string> asked_;
  std::vector<size_t> terms_;  // among effects, those that are terms of the model
};

}  // namespace

PlantedArm plant_effects(const Model& arm, const std::vector<HiddenEffect>& hidden) {
  Planter planter(arm);
  for (const HiddenEffect& one : hidden) planter.plant(one);
  return std::move(planter).finish();
}

}  // namespace veridyn
