#include "registry.hpp"

#include <cstring>
#include <utility>

#include "veridyn/effects/cause.hpp"
#include "veridyn/math/require.hpp"
#include "model/suggestion.hpp"
#include "effects/effect_names.hpp"

namespace veridyn {
namespace {

// All effects, sorted by kind: built-in ones in the order of docs/contract.md, then registered
// ones.
class Registry {
 public:
  Registry() {
#define VERIDYN_ADD_EFFECT(name) add(&name());
    VERIDYN_EFFECTS(VERIDYN_ADD_EFFECT)
#undef VERIDYN_ADD_EFFECT
    for (const std::string& cause : names_of_causes()) file_names_.push_back(cause);
  }

  static Registry& instance() {
    static Registry registry;
    return registry;
  }

  void add(const Effect* effect) {
    all_.push_back(effect);
    if (const auto* axis = dynamic_cast<const AxisEffect*>(effect)) axis_.push_back(axis);
    if (const auto* channel = dynamic_cast<const ChannelEffect*>(effect))
      channels_.push_back(channel);
    file_names_.push_back(effect->name());
  }

  const Effect& register_and_keep(std::unique_ptr<const Effect> effect) {
    owned_.push_back(std::move(effect));
    add(owned_.back().get());
    return *owned_.back();
  }

  const std::vector<const Effect*>& all() const { return all_; }
  const std::vector<const AxisEffect*>& axis() const { return axis_; }
  const std::vector<const ChannelEffect*>& channels() const { return channels_; }
  const std::vector<std::string>& file_names() const { return file_names_; }

 private:
  std::vector<const Effect*> all_;
  std::vector<const AxisEffect*> axis_;
  std::vector<const ChannelEffect*> channels_;
  std::vector<std::string> file_names_;
  std::vector<std::unique_ptr<const Effect>> owned_;
};

template <typename Kind>
const Kind* find(const std::vector<const Kind*>& effects, const std::string& name) {
  for (const Kind* effect : effects) {
    if (effect->name() == name) return effect;
  }
  return nullptr;
}

template <typename Kind>
std::vector<std::string> names_of_effects(const std::vector<const Kind*>& effects) {
  std::vector<std::string> out;
  for (const Kind* effect : effects) out.push_back(effect->name());
  return out;
}

bool is_key_of_terms(const std::string& name) {
  for (const std::string& key : effect_keys()) {
    if (key == name) return true;
  }
  return false;
}

// Throws InvalidInput if the effect cannot be registered.
void check(const Effect& effect) {
  const std::string name = effect.name();
  for (const std::string& taken : effect_names())
    require(name != taken, "register_effect: the name '", name, "' is taken.");
  const EffectRole role = effect.traits().role;
  require(role == EffectRole::kSensor ? dynamic_cast<const SensorError*>(&effect) != nullptr
          : role == EffectRole::kArm  ? dynamic_cast<const ArmEffect*>(&effect) != nullptr
                                      : dynamic_cast<const AxisEffect*>(&effect) != nullptr,
          "register_effect: '", name,
          "' is neither an AxisEffect, nor a SensorError whose role is kSensor, nor an ArmEffect "
          "whose role is kArm.");
  const std::vector<EffectParameter> parameters = effect.parameters();
  const std::vector<EffectShape> shapes = effect.shapes();
  require(!parameters.empty() && parameters.size() <= size_t{kMaxEffectParameters},
          "register_effect: '", name, "' has ", parameters.size(), " parameters, expected 1 to ",
          kMaxEffectParameters, ".");
  require(shapes.size() <= size_t{kMaxEffectShapes}, "register_effect: '", name, "' has ",
          shapes.size(), " shape constants, expected at most ", kMaxEffectShapes, ".");
  for (const EffectParameter& p : parameters)
    require(!is_key_of_terms(p.name) || has_offset_parameter(name) || p.name == "offset",
            "register_effect: '", name, "': '", p.name, "' is a key of robot files.");
  for (const EffectShape& s : shapes) {
    require(!is_key_of_terms(s.name), "register_effect: '", name, "': '", s.name,
            "' is a key of robot files.");
    require(!s.searched || (s.lower < s.upper && s.lower > 0.0), "register_effect: '", name,
            "': ", s.name, " is searched from ", s.lower, " to ", s.upper,
            ", expected a range above zero.");
  }
}

}  // namespace

const std::vector<std::string>& effect_keys() {
  static const std::vector<std::string> keys{"effect",      "axis",  "offset", "from",
                                             "from_offset", "frame", "values", "std"};
  return keys;
}

const std::vector<const Effect*>& all_effects() {
  return Registry::instance().all();
}

const std::vector<const AxisEffect*>& axis_effects() {
  return Registry::instance().axis();
}

const std::vector<const ChannelEffect*>& channel_effects() {
  return Registry::instance().channels();
}

bool has_effect(const std::string& name) {
  return find(all_effects(), name) != nullptr;
}

bool has_axis_effect(const std::string& name) {
  return find(axis_effects(), name) != nullptr;
}

const ChannelEffect* channel_effect(const std::string& name) {
  return find(channel_effects(), name);
}

const Effect& find_effect(const std::string& name) {
  if (const Effect* effect = find(all_effects(), name)) return *effect;
  const std::vector<std::string> known = names_of_effects(all_effects());
  throw InvalidInput(text("found the unknown effect '", name, "'", did_you_mean(name, known),
                          ", expected one of: ", listed(known), "."));
}

const AxisEffect& find_axis_effect(const std::string& name) {
  if (const AxisEffect* effect = find(axis_effects(), name)) return *effect;
  const std::vector<std::string> known = names_of_effects(axis_effects());
  throw InvalidInput(text("effect '", name, "' cannot act along an axis of a model",
                          did_you_mean(name, known), "; these can: ", listed(known), "."));
}

const Effect& register_effect(std::unique_ptr<const Effect> effect) {
  require(effect != nullptr, "register_effect: found no effect.");
  check(*effect);
  return Registry::instance().register_and_keep(std::move(effect));
}

// Defines the functions of effects/effect_names.hpp for the reader of robot files.

const std::vector<std::string>& effect_names() {
  return Registry::instance().file_names();
}

bool may_lack_axis(const std::string& effect) {
  if (const ChannelEffect* channel = channel_effect(effect)) return channel->whole_arm();
  return effect == KinematicError::kName;
}

bool has_offset_parameter(const std::string& effect) {
  const Effect* known = find(all_effects(), effect);
  if (known == nullptr) return false;
  for (const EffectParameter& p : known->parameters()) {
    if (p.name == "offset") return true;
  }
  return false;
}

std::optional<std::pair<std::string, std::string>> effect_of_attribute(const std::string& attribute) {
  for (const AxisEffect* effect : axis_effects()) {
    if (effect->traits().urdf_attribute == attribute)
      return std::make_pair(effect->name(), effect->parameters().front().name);
  }
  return std::nullopt;
}

}  // namespace veridyn
