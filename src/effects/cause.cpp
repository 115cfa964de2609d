#include "veridyn/effects/cause.hpp"

#include "veridyn/effects/channel_effect.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/math/require.hpp"
#include "model/effect_names.hpp"
#include "model/suggestion.hpp"

namespace veridyn {
namespace {

constexpr size_t kDigits = 3;  // number of digits of a joint's number

template <typename... Visitors>
struct Overloaded : Visitors... {
  using Visitors::operator()...;
};
template <typename... Visitors>
Overloaded(Visitors...) -> Overloaded<Visitors...>;

bool is_number(const std::string& word) {
  return !word.empty() && word.size() <= kDigits &&
         word.find_first_not_of("0123456789") == std::string::npos;
}

std::string find_constant(const Model& arm, const std::string& word, const std::string& where) {
  std::vector<std::string> names;
  for (const auto& [name, value] : arm.description().constants) names.push_back(name);
  require(arm.description().constants.count(word) > 0, where, ": found '", word, "'",
          did_you_mean(word, names), ", expected a constant of the robot file, one of: ",
          names.empty() ? "(it has none)" : listed(names), ".");
  return word;
}

std::string place_of(const Model& arm, const Cause& cause) {
  const auto joint = [&arm](JointIndex i) {
    return arm.coordinates()[static_cast<size_t>(i.value)].name;
  };
  const auto frame = [&arm](FrameIndex k) {
    return arm.frames()[static_cast<size_t>(k.value)].name;
  };
  return std::visit(
      Overloaded{[&](const NewEffect& c) { return joint(c.joint); },
                 [&](const ChangedEffect& c) { return joint(c.joint); },
                 [&](const AddedLoad& c) { return frame(c.frame); },
                 [&](const AddedInertia& c) { return frame(c.frame); },
                 [&](const ChannelError& c) { return c.joint ? joint(*c.joint) : kWholeArm; },
                 [&](const KinematicError& c) { return c.constant; },
                 [&](const ExternalContact& c) { return joint(c.joint); }},
      cause);
}

}  // namespace

CauseText split_cause(const std::string& words) {
  const auto colon = words.find(':');
  if (colon == std::string::npos) return {words, ""};
  return {words.substr(0, colon), words.substr(colon + 1)};
}

std::string to_text(const CauseText& cause) {
  return cause.place.empty() ? cause.effect : cause.effect + ":" + cause.place;
}

JointIndex find_joint(const Model& arm, const std::string& word, const std::string& where) {
  std::vector<std::string> names;
  for (const Coordinate& c : arm.coordinates()) names.push_back(c.name);
  int joint = arm.find_coordinate(word);
  if (joint < 0 && is_number(word)) joint = std::stoi(word) - 1;
  require(joint >= 0 && joint < arm.joints(), where, ": found the joint '", word, "'",
          did_you_mean(word, names), ", expected a number from 1 to ", arm.joints(),
          " or one of: ", listed(names), ".");
  return {joint};
}

FrameIndex find_frame(const Model& arm, const std::string& word, const std::string& where) {
  std::vector<std::string> names;
  for (const Frame& frame : arm.frames()) names.push_back(frame.name);
  const int k = arm.find_frame(word);
  require(k >= 0, where, ": found the frame '", word, "'", did_you_mean(word, names),
          ", expected one of: ", listed(names), ".");
  return {k};
}

Cause find_cause(const Model& arm, const CauseText& cause, const std::string& where) {
  const auto& [effect, place] = cause;
  if (effect == AddedLoad::kName) return AddedLoad{find_frame(arm, place, where)};
  if (effect == AddedInertia::kName) return AddedInertia{find_frame(arm, place, where)};
  if (effect == KinematicError::kName) return KinematicError{find_constant(arm, place, where)};
  if (effect == ExternalContact::kName) return ExternalContact{find_joint(arm, place, where)};
  if (const ChannelEffect* channel = channel_effect(effect)) {
    if (place == kWholeArm || (place.empty() && channel->whole_arm()))
      return ChannelError{effect, std::nullopt};
    require(!channel->whole_arm(), where, ": found the place '", place, "', expected '", kWholeArm,
            "': it is one of the whole arm.");
    return ChannelError{effect, find_joint(arm, place, where)};
  }
  require(has_axis_effect(effect), where, ": found the unknown effect '", effect, "'",
          did_you_mean(effect, effect_names()), ", expected one of: ", listed(effect_names()), ".");
  return NewEffect{effect, find_joint(arm, place, where)};
}

Cause parse_cause(const Model& arm, const std::string& words) {
  return find_cause(arm, split_cause(words), "cause '" + words + "'");
}

std::string to_text(const Model& arm, const Cause& cause) {
  return to_text(CauseText{effect_of(cause), place_of(arm, cause)});
}

std::string effect_of(const Cause& cause) {
  return std::visit(
      Overloaded{[](const NewEffect& c) { return c.effect; },
                 [](const ChangedEffect& c) { return c.effect; },
                 [](const ChannelError& c) { return c.effect; },
                 [](const auto& c) { return std::string(std::decay_t<decltype(c)>::kName); }},
      cause);
}

std::optional<JointIndex> joint_of(const Cause& cause) {
  using Joint = std::optional<JointIndex>;
  return std::visit(Overloaded{[](const NewEffect& c) { return Joint(c.joint); },
                               [](const ChangedEffect& c) { return Joint(c.joint); },
                               [](const ChannelError& c) { return c.joint; },
                               [](const ExternalContact& c) { return Joint(c.joint); },
                               [](const auto& /*c*/) { return Joint(); }},
                    cause);
}

std::optional<FrameIndex> frame_of(const Cause& cause) {
  using At = std::optional<FrameIndex>;
  return std::visit(Overloaded{[](const AddedLoad& c) { return At(c.frame); },
                               [](const AddedInertia& c) { return At(c.frame); },
                               [](const auto& /*c*/) { return At(); }},
                    cause);
}

std::vector<std::string> names_of_causes() {
  return {AddedLoad::kName, KinematicError::kName, ExternalContact::kName};
}

}  // namespace veridyn
