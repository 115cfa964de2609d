#include "veridyn/effects/cause.hpp"

#include "effects/kinematic_error.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/math/require.hpp"
#include "model/effect_names.hpp"
#include "model/suggestion.hpp"

namespace veridyn {
namespace {

constexpr size_t kDigits = 3;  // digits of a joint's number

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

const char* const kRatioOf = "ratio of ";

// The rest of `word` after "elbow.", if it begins so.
std::optional<std::string> after(const std::string& owner, const std::string& word) {
  const std::string start = owner + ".";
  if (word.compare(0, start.size(), start) != 0) return std::nullopt;
  return word.substr(start.size());
}

bool is_in_row(const Model& arm, const Frame& frame, const std::string& name) {
  if (!frame.dh) return false;
  if (name == "theta" || name == "alpha" || name == "a" || name == "d") return true;
  for (int i = 0; i < arm.joints(); ++i) {
    if (name == kRatioOf + arm.coordinates()[i].name)
      return frame.variable.coefficients[i] != 0.0;
  }
  return false;
}

// The number in a row with this name; nullptr: it is a ratio.
double* number_of(DhRow& row, const std::string& name) {
  if (name == "theta") return &row.theta;
  if (name == "alpha") return &row.alpha;
  if (name == "a") return &row.a;
  return name == "d" ? &row.d : nullptr;
}

double& ratio_of(Frame& frame, const std::string& name, const ModelDescription& arm) {
  Eigen::Index i = 0;
  while (name != kRatioOf + arm.coordinates[i].name) ++i;
  return frame.variable.coefficients[i];
}

// Contribution of a row to the joint variable's offset.
double offset_of(const Frame& frame, const DhRow& row) {
  if (frame.type == JointType::kFixed) return 0.0;
  return frame.type == JointType::kRevolute ? row.theta : row.d;
}

KinematicError find_constant(const Model& arm, const std::string& word, const std::string& where) {
  for (int k = 0; k < static_cast<int>(arm.frames().size()); ++k) {
    const Frame& frame = arm.frames()[k];
    const auto name = after(frame.name, word);
    if (name && is_in_row(arm, frame, *name)) return {*name, FrameIndex{k}};
  }
  for (int i = 0; i < arm.joints(); ++i) {
    if (after(arm.coordinates()[i].name, word) == KinematicError::kZero)
      return {KinematicError::kZero, JointIndex{i}};
  }
  std::vector<std::string> names;
  for (const auto& [name, value] : arm.description().constants) names.push_back(name);
  require(arm.description().constants.count(word) > 0, where, ": found '", word, "'",
          did_you_mean(word, names), ", expected a constant of the robot file, one of: ",
          names.empty() ? "(it has none)" : listed(names),
          "; or one of a frame's row, as in FRAME.theta; or JOINT.zero.");
  return {word};
}

std::string place_of(const Model& arm, const Cause& cause) {
  const auto joint = [&arm](JointIndex i) {
    return arm.coordinates()[i.value].name;
  };
  const auto frame = [&arm](FrameIndex k) {
    return arm.frames()[k.value].name;
  };
  return std::visit(
      Overloaded{[&](const NewEffect& c) { return joint(c.joint); },
                 [&](const ChangedEffect& c) { return joint(c.joint); },
                 [&](const AddedLoad& c) { return frame(c.frame); },
                 [&](const AddedInertia& c) { return frame(c.frame); },
                 [&](const ChannelError& c) { return c.joint ? joint(*c.joint) : kWholeArm; },
                 [&](const KinematicError& c) {
                   const auto owner = std::visit(
                       Overloaded{[](std::monostate) { return std::string(); },
                                  [&](FrameIndex k) { return frame(k) + "."; },
                                  [&](JointIndex i) { return joint(i) + "."; }},
                       c.of);
                   return owner + c.constant;
                 },
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
  if (effect == KinematicError::kName) return find_constant(arm, place, where);
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

double value_of(const KinematicError& error, const ModelDescription& arm) {
  const auto* of = std::get_if<FrameIndex>(&error.of);
  if (of == nullptr) return 0.0;
  Frame frame = arm.frames[of->value];
  const double* number = number_of(*frame.dh, error.constant);
  return number != nullptr ? *number : ratio_of(frame, error.constant, arm);
}

void set_value(const KinematicError& error, double value, ModelDescription& arm) {
  if (const auto* joint = std::get_if<JointIndex>(&error.of)) {
    for (Frame& frame : arm.frames)
      frame.variable.offset += frame.variable.coefficients[joint->value] * value;
    return;
  }
  Frame& frame = arm.frames[std::get<FrameIndex>(error.of).value];
  DhRow row = *frame.dh;
  frame.variable.offset -= offset_of(frame, row);  // place() adds the new one
  double* number = number_of(row, error.constant);
  (number != nullptr ? *number : ratio_of(frame, error.constant, arm)) = value;
  place(frame, row);
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
                               [](const KinematicError& c) {
                                 const auto* joint = std::get_if<JointIndex>(&c.of);
                                 return joint != nullptr ? Joint(*joint) : Joint();
                               },
                               [](const auto& /*c*/) { return Joint(); }},
                    cause);
}

std::optional<FrameIndex> frame_of(const Cause& cause) {
  using At = std::optional<FrameIndex>;
  return std::visit(Overloaded{[](const AddedLoad& c) { return At(c.frame); },
                               [](const AddedInertia& c) { return At(c.frame); },
                            [](const KinematicError& c) {
                              const auto* frame = std::get_if<FrameIndex>(&c.of);
                              return frame != nullptr ? At(*frame) : At();
                            },
                               [](const auto& /*c*/) { return At(); }},
                    cause);
}

std::optional<JointIndex> acting_joint(const Model& arm, const Cause& cause) {
  const std::optional<FrameIndex> frame = frame_of(cause);
  if (!frame) return joint_of(cause);
  JointIndex last;
  for (int i = 0; i < arm.joints(); ++i) {
    if (arm.moves(frame->value, i)) last.value = i;
  }
  return last;
}

bool alike(const Cause& a, const Cause& b) {
  return effect_of(a) == effect_of(b) && joint_of(a) == joint_of(b) && frame_of(a) == frame_of(b);
}

CauseWords words_of(const Model& arm, const Cause& cause) {
  CauseWords out;
  out.effect = effect_of(cause);
  const std::optional<JointIndex> joint = acting_joint(arm, cause);
  out.joint = joint ? joint->value + 1 : 0;
  out.coordinate = joint ? arm.coordinates()[joint->value].name : kWholeArm;
  if (const auto frame = frame_of(cause))
    out.frame = arm.frames()[frame->value].name;
  if (const auto* constant = std::get_if<KinematicError>(&cause)) out.constant = constant->constant;
  if (const auto* contact = std::get_if<ExternalContact>(&cause)) {
    int k = 0;
    while (!arm.moves(k, contact->joint.value)) ++k;
    out.frame = arm.frames()[k].name;
  }
  return out;
}

std::vector<std::string> names_of_causes() {
  return {AddedLoad::kName, KinematicError::kName, ExternalContact::kName};
}

}  // namespace veridyn
