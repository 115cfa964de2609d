#include <algorithm>
#include <utility>
#include <variant>

#include "effect_sizes.hpp"
#include "effects/kinematic_error.hpp"
#include "veridyn/effects/cause.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "kinematics/motion_limits.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "model/suggestion.hpp"
#include "veridyn/simulation/hidden_effect.hpp"
#include "veridyn/effects/effect_facts.hpp"

namespace veridyn {
namespace {

// All keys of a hidden effect, with their default values.
using Defaults = std::vector<std::pair<std::string, double>>;

// The defaults with the values of the request in their place; throws InvalidInput for any other key.
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

// Adds effects one after the other to the description.
class Injector {
 public:
  explicit Injector(const Model& arm)
      : out_{arm, {}, JointSensors(arm), {}}, effort_(standard_effort(arm)) {
    for (const Coordinate& c : arm.coordinates()) shown_.push_back(c.recorded);
  }

  void inject(const HiddenEffect& hidden) {
    const Cause cause =
        find_cause(out_.arm, {hidden.effect, hidden.place}, "effect '" + hidden.asked + "'");
    std::visit([&](const auto& one) { inject(hidden, one); }, cause);
  }

  PerturbedArm finish() && {
    // New terms are at the end of the model's effects, in the order of the request.
    size_t term = out_.arm.effects().size() - terms_.size();
    const Model sized = with_sensible_effects(out_.arm);
    for (const size_t injected : terms_) {
      require(has_all_values(term) || has_force(sized.effects()[term]), "effect '", asked_[injected],
              "': found no sensible size for it on this arm, expected its parameters.");
      out_.effects[injected].values = sized.effects()[term].values;
      ++term;
    }
    out_.arm = sized;
    out_.sensors = JointSensors(shown_);
    return std::move(out_);
  }

 private:
  // Lists the effect among the injected ones; the inject() functions change the arm, its sensors or contacts and call it.
  void add(const HiddenEffect& hidden, std::string place, std::optional<JointIndex> joint,
           std::map<std::string, double> values) {
    out_.effects.push_back({hidden.effect, std::move(place), joint, std::move(values)});
    asked_.push_back(hidden.asked);
  }

  void add(const HiddenEffect& hidden, JointIndex joint, std::map<std::string, double> values) {
    add(hidden, coordinate_of(joint).name, joint, std::move(values));
  }

  const Coordinate& coordinate_of(JointIndex joint) const {
    return out_.arm.coordinates()[joint.value];
  }

  void inject(const HiddenEffect& hidden, const ChannelError& cause) {
    const ChannelEffect& channel = *channel_effect(cause.effect);
    const bool slides = cause.joint && coordinate_of(*cause.joint).prismatic;
    const std::vector<InjectedValue> keys =
        channel.injected(slides ? JointType::kPrismatic : JointType::kRevolute);
    Defaults defaults;
    for (const InjectedValue& key : keys) defaults.emplace_back(key.key, key.initial);
    const std::optional<JointIndex> from = source_of(hidden, channel, cause.joint);
    HiddenEffect numbers = hidden;
    if (from) numbers.from.clear();
    auto values = filled(numbers, defaults);
    std::vector<double> parameters;
    for (const InjectedValue& key : keys) {
      const double value = values[key.key];
      require(!key.nonnegative || value >= 0.0, "effect '", hidden.asked, "': found ", key.key, "=",
              value, ", expected none below zero.");
      parameters.push_back(value - key.zero);
    }
    if (const auto* sensor = dynamic_cast<const SensorError*>(&channel)) {
      for (size_t i = 0; i < shown_.size(); ++i) {
        if (!cause.joint || static_cast<int>(i) == cause.joint->value)
          sensor->add_to_channel(shown_[i], from, parameters);
      }
    } else {
      ModelDescription arm = out_.arm.description();
      channel.apply(arm, std::nullopt, from, parameters);
      out_.arm = Model(std::move(arm));
    }
    if (cause.joint) {
      add(hidden, *cause.joint, std::move(values));
    } else {
      add(hidden, kWholeArm, std::nullopt, std::move(values));
    }
  }

  // The joint given by from=; nullopt for an error without a source.
  std::optional<JointIndex> source_of(const HiddenEffect& hidden, const ChannelEffect& channel,
                                      std::optional<JointIndex> joint) const {
    if (!channel.traits().uses_source) return std::nullopt;
    require(!hidden.from.empty(), "effect '", hidden.asked, "': found no source, expected from=JOINT.");
    const JointIndex from = find_joint(out_.arm, hidden.from, "effect '" + hidden.asked + "'");
    require(joint != from, "effect '", hidden.asked, "': found the joint itself as its source, "
            "expected another one.");
    return from;
  }

  void inject(const HiddenEffect& hidden, const ExternalContact& cause) {
    const double usual = 0.5 * effort_[cause.joint.value];
    auto v = filled(hidden, {{"from", 5.0}, {"to", 7.0}, {"effort", usual}});
    require(v["from"] < v["to"], "effect '", hidden.asked, "': found a contact from ", v["from"],
            " s to ", v["to"], " s, expected it to end after it begins.");
    out_.contacts.push_back({cause.joint, v["from"], v["to"], v["effort"]});
    add(hidden, cause.joint, std::move(v));
  }

  void inject(const HiddenEffect& hidden, const AddedLoad& cause) {
    ModelDescription arm = out_.arm.description();
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
    std::optional<Body>& body = arm.frames[cause.frame.value].body;
    if (!body) {
      body = Body{};
      body->phi = InertialParameters::Zero();
      body->fixed = true;
    }
    *body->phi += load;
    out_.arm = Model(std::move(arm));
    add(hidden, hidden.place, std::nullopt, std::move(v));
  }

  void inject(const HiddenEffect& hidden, const KinematicError& cause) {
    const auto* named = std::get_if<NamedConstant>(&cause.constant);
    if (named == nullptr) {
      inject_number(hidden, cause);
      return;
    }
    const auto constant = out_.arm.description().constants.find(named->name);
    const double size = constant->second != 0.0 ? 0.1 * constant->second : 0.05;
    auto v = filled(hidden, {{"change", size}});
    ModelFileOptions options;
    options.constants[named->name] = constant->second + v["change"];
    out_.arm = read_yaml(to_yaml(out_.arm), out_.arm.name(), options);
    add(hidden, hidden.place, std::nullopt, std::move(v));
  }

  // Changes a number of a frame or a joint's zero.
  void inject_number(const HiddenEffect& hidden, const KinematicError& cause) {
    ModelDescription arm = out_.arm.description();
    const double before = value_of(cause, arm);
    auto v = filled(hidden, {{"change", before != 0.0 ? 0.1 * before : 0.05}});
    set_value(cause, before + v["change"], arm);
    out_.arm = Model(std::move(arm));
    add(hidden, hidden.place, std::nullopt, std::move(v));
  }

  // Only a diagnosis writes this form of a cause.
  void inject(const HiddenEffect& hidden, const AddedInertia& /*cause*/) {
    throw InvalidInput(text("effect '", hidden.asked, "': found '", hidden.effect,
                            "', which is a load without mass, expected '", AddedLoad::kName, "'."));
  }

  void inject(const HiddenEffect& hidden, const ChangedEffect& cause) {
    inject(hidden, NewEffect{cause.effect, cause.joint});
  }

  void inject(const HiddenEffect& hidden, const NewEffect& cause) {
    const int joint = cause.joint.value;
    EffectTerm term;
    term.effect = hidden.effect;
    term.axis.coefficients = VectorXd::Unit(out_.arm.joints(), joint);
    term.values = hidden.values;
    const AxisEffect& effect = find_axis_effect(hidden.effect);
    std::vector<std::string> keys;
    for (const EffectParameter& p : effect.parameters()) keys.push_back(p.name);
    for (const EffectShape& s : effect.shapes()) {
      keys.push_back(s.name);
    }
    const bool coupled = effect.traits().uses_source;
    if (coupled) {
      keys.emplace_back("from");
      require(!hidden.from.empty(), "effect '", hidden.asked,
              "': found no source, expected from=JOINT.");
      term.from = Axis{
          VectorXd::Unit(out_.arm.joints(),
                         find_joint(out_.arm, hidden.from, "effect '" + hidden.asked + "'").value),
          0.0};
    }
    const std::string extra = !hidden.from.empty() && !coupled ? "from" : unknown_key(hidden, keys);
    require(extra.empty(), "effect '", hidden.asked, "': found the key '", extra, "'",
            did_you_mean(extra, keys), ", expected one of: ", listed(keys), ".");
    fill_shapes(effect, joint, term);
    ModelDescription arm = out_.arm.description();
    arm.effects.push_back(std::move(term));
    out_.arm = Model(std::move(arm));
    terms_.push_back(out_.effects.size());
    add(hidden, cause.joint, {});
  }

  // Missing shape constants get the effect's own values; a range that the caller must set is that
  // of the joint.
  void fill_shapes(const AxisEffect& effect, int joint, EffectTerm& term) const {
    const MotionLimits limits = motion_limits(out_.arm);
    const ShapeValues initial = EffectFacts(out_.arm, term).shape();
    const std::vector<EffectShape> shapes = effect.shapes();
    for (size_t k = 0; k < shapes.size(); ++k) {
      const EffectShape& shape = shapes[k];
      double value = initial[k];
      if (shape.scale == ShapeScale::kMiddle)
        value = 0.5 * (limits.lower[joint] + limits.upper[joint]);
      if (shape.scale == ShapeScale::kTravel && !shape.searched)
        value = shape.grid.front() * (limits.upper[joint] - limits.lower[joint]);
      const bool can_stand_in_files = value > 0.0 || !shape.logarithmic;
      if (can_stand_in_files) term.values.emplace(shape.name, value);
    }
  }

  // True if the request gave all parameters of a term.
  bool has_all_values(size_t term) const {
    return EffectFacts(out_.arm, out_.arm.effects()[term]).has_values();
  }

  // True if some parameter of the effect is not zero.
  static bool has_force(const EffectTerm& term) {
    for (const EffectParameter& p : find_axis_effect(term.effect).parameters()) {
      if (term.values.at(p.name) != 0.0) return true;
    }
    return false;
  }

  // The first key of the request that is none of these; empty: none.
  static std::string unknown_key(const HiddenEffect& hidden, const std::vector<std::string>& keys) {
    for (const auto& [key, value] : hidden.values) {
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) return key;
    }
    return "";
  }

  PerturbedArm out_;
  std::vector<RecordedChannel> shown_;  // errors of the recorded signals by joint
  VectorXd effort_;
  std::vector<std::string> asked_;
  std::vector<size_t> terms_;  // indices of the new terms among the model's effects
};

}  // namespace

PerturbedArm inject_effects(const Model& arm, const std::vector<HiddenEffect>& hidden) {
  Injector injector(arm);
  for (const HiddenEffect& one : hidden) injector.inject(one);
  return std::move(injector).finish();
}

}  // namespace veridyn
