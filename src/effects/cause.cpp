#include "veridyn/effects/cause.hpp"

#include <array>
#include <map>
#include <tuple>

#include "effects/kinematic_error.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/math/require.hpp"
#include "effects/effect_names.hpp"
#include "model/joint_placement.hpp"
#include "model/suggestion.hpp"

namespace veridyn {
namespace {

constexpr size_t kDigits = 3;  // largest number of digits of a joint's number

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

const char* const kZero = "zero";

// Names of FrameNumber in files and messages, in its order; the name of a ratio also contains its joint.
constexpr std::array<const char*, 11> kFrameNumbers = {"a", "alpha", "d",     "theta", "x",        "y",
                                                       "z", "roll",  "pitch", "yaw",   "ratio of "};
constexpr int kOfRow = 4;  // the first four are those of a DH row

const char* frame_number_word(FrameNumber number) {
  return kFrameNumbers[static_cast<int>(number)];
}

// The part of `word` after "elbow." if it begins with this owner's name and a dot.
std::optional<std::string> after(const std::string& owner, const std::string& word) {
  const std::string start = owner + ".";
  if (word.compare(0, start.size(), start) != 0) return std::nullopt;
  return word.substr(start.size());
}

// All numbers of a frame in the order of FrameNumber; either those of a DH row or those of an origin are set.
using FrameNumbers = std::array<double, kFrameNumbers.size() - 1>;

FrameNumbers numbers_of(const Frame& frame) {
  if (frame.dh) return {frame.dh->a, frame.dh->alpha, frame.dh->d, frame.dh->theta};
  const Posed origin = joint_placement(frame).origin;
  const Vec3d rpy = rpy_from_rotation(origin.R);
  return {0.0, 0.0, 0.0, 0.0, origin.p.x, origin.p.y, origin.p.z, rpy.x, rpy.y, rpy.z};
}

// Contribution of the DH row to the joint variable's offset.
double offset_of(const Frame& frame, const DhRow& row) {
  if (frame.type == JointType::kFixed) return 0.0;
  return frame.type == JointType::kRevolute ? row.theta : row.d;
}

// Places the frame anew by these numbers, those of its DH row if it has one, else of its origin.
void set_frame_numbers(Frame& frame, const FrameNumbers& v) {
  if (frame.dh) {
    DhRow row = *frame.dh;
    frame.variable.offset -= offset_of(frame, row);  // place() adds the new offset
    std::tie(row.a, row.alpha, row.d, row.theta) = std::tie(v[0], v[1], v[2], v[3]);
    place(frame, row);
    return;
  }
  JointPlacement placed = joint_placement(frame);
  placed.origin = {rotation_from_rpy({v[7], v[8], v[9]}), {v[4], v[5], v[6]}};
  place(frame, placed);
}

// The constant "FRAME.theta", "JOINT.zero" or one of the file's own; throws InvalidInput if there is none.
KinematicError find_constant(const Model& arm, const std::string& word, const std::string& where) {
  for (int k = 0; k < static_cast<int>(arm.frames().size()); ++k) {
    const auto name = after(arm.frames()[k].name, word);
    for (const FrameConstant& c : name ? constants_of(arm, {k}) : std::vector<FrameConstant>()) {
      if (name_of(arm, c) == *name) return {c};
    }
  }
  for (int i = 0; i < arm.joints(); ++i) {
    if (after(arm.coordinates()[i].name, word) == kZero) return {JointZero{{i}}};
  }
  std::vector<std::string> names;
  for (const auto& [name, value] : arm.description().constants) names.push_back(name);
  require(arm.description().constants.count(word) > 0, where, ": found '", word, "'",
          did_you_mean(word, names), ", expected a constant of the robot file, one of: ",
          names.empty() ? "(it has none)" : listed(names),
          "; or a number of a frame, as in FRAME.theta or FRAME.yaw; or JOINT.zero.");
  return {NamedConstant{word}};
}

// PLACE of the cause's text form, with the joint's name.
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
                   return std::visit(
                       Overloaded{[](const NamedConstant& n) { return n.name; },
                                  [&](const FrameConstant& n) { return frame(n.frame) + "." + name_of(arm, n); },
                                  [&](JointZero n) { return joint(n.joint) + "." + kZero; }},
                       c.constant);
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
  std::optional<JointIndex> joint = arm.find_coordinate(word);
  if (!joint && is_number(word)) joint = {std::stoi(word) - 1};
  require(joint && joint->value >= 0 && joint->value < arm.joints(), where, ": found the joint '", word, "'",
          did_you_mean(word, names), ", expected a number from 1 to ", arm.joints(),
          " or one of: ", listed(names), ".");
  return *joint;
}

FrameIndex find_frame(const Model& arm, const std::string& word, const std::string& where) {
  std::vector<std::string> names;
  for (const Frame& frame : arm.frames()) names.push_back(frame.name);
  const std::optional<FrameIndex> k = arm.find_frame(word);
  require(k.has_value(), where, ": found the frame '", word, "'", did_you_mean(word, names),
          ", expected one of: ", listed(names), ".");
  return *k;
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

std::vector<FrameConstant> constants_of(const Model& arm, FrameIndex k) {
  const Frame& frame = arm.frames()[k.value];
  const int ratio = static_cast<int>(FrameNumber::kRatio);
  std::vector<FrameConstant> out;
  for (int n = frame.dh ? 0 : kOfRow; n < (frame.dh ? kOfRow : ratio); ++n)
    out.push_back({k, static_cast<FrameNumber>(n)});
  for (int i = 0; i < arm.joints(); ++i) {
    if (frame.variable.coefficients[i] != 0.0) out.push_back({k, FrameNumber::kRatio, JointIndex{i}});
  }
  return out;
}

std::string name_of(const Model& arm, const FrameConstant& constant) {
  const std::string word = frame_number_word(constant.number);
  return constant.joint ? word + arm.coordinates()[constant.joint->value].name : word;
}

std::string unit_of(const FrameConstant& constant) {
  switch (constant.number) {
    case FrameNumber::kA:
    case FrameNumber::kD:
    case FrameNumber::kX:
    case FrameNumber::kY:
    case FrameNumber::kZ: return "m";
    case FrameNumber::kRatio: return "1";
    default: return "rad";
  }
}

std::string formula_key(const Model& arm, const FrameConstant& constant) {
  const Frame& frame = arm.frames()[constant.frame.value];
  const std::string key = "frames/" + frame.name;
  const int n = static_cast<int>(constant.number);
  if (constant.joint) {
    const char* joint = frame.type == JointType::kRevolute ? "/revolute/" : "/prismatic/";
    return key + joint + arm.coordinates()[constant.joint->value].name;
  }
  if (n < kOfRow) return key + "/dh/" + std::to_string(n);
  const int axis = (n - kOfRow) % 3;
  return key + (axis == n - kOfRow ? "/origin/xyz/" : "/origin/rpy/") + std::to_string(axis);
}

double value_of(const KinematicError& error, const ModelDescription& arm) {
  const auto* of = std::get_if<FrameConstant>(&error.constant);
  if (of == nullptr) return 0.0;
  const Frame& frame = arm.frames[of->frame.value];
  if (of->joint) return frame.variable.coefficients[of->joint->value];
  return numbers_of(frame)[static_cast<int>(of->number)];
}

void set_value(const KinematicError& error, double value, ModelDescription& arm) {
  if (const auto* zero = std::get_if<JointZero>(&error.constant)) {
    for (Frame& frame : arm.frames)
      frame.variable.offset += frame.variable.coefficients[zero->joint.value] * value;
    return;
  }
  set_values({{std::get<FrameConstant>(error.constant), value}}, arm);
}

void set_values(const std::vector<std::pair<FrameConstant, double>>& values, ModelDescription& arm) {
  std::map<int, FrameNumbers> placed;
  for (const auto& [constant, value] : values) {
    const int k = constant.frame.value;
    if (constant.joint) {
      arm.frames[k].variable.coefficients[constant.joint->value] = value;
    } else {
      placed.emplace(k, numbers_of(arm.frames[k])).first->second[static_cast<int>(constant.number)] = value;
    }
  }
  for (const auto& [k, numbers] : placed) set_frame_numbers(arm.frames[k], numbers);
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
                                 const auto* zero = std::get_if<JointZero>(&c.constant);
                                 return zero != nullptr ? Joint(zero->joint) : Joint();
                               },
                               [](const auto& /*c*/) { return Joint(); }},
                    cause);
}

std::optional<FrameIndex> frame_of(const Cause& cause) {
  using At = std::optional<FrameIndex>;
  return std::visit(Overloaded{[](const AddedLoad& c) { return At(c.frame); },
                               [](const AddedInertia& c) { return At(c.frame); },
                               [](const KinematicError& c) {
                                 const auto* of = std::get_if<FrameConstant>(&c.constant);
                                 return of != nullptr ? At(of->frame) : At();
                               },
                               [](const auto& /*c*/) { return At(); }},
                    cause);
}

std::optional<JointIndex> acting_joint(const Model& arm, const Cause& cause) {
  const std::optional<FrameIndex> frame = frame_of(cause);
  if (!frame) return joint_of(cause);
  JointIndex last;
  for (int i = 0; i < arm.joints(); ++i) {
    if (arm.moves(*frame, {i})) last = {i};
  }
  return last;
}

bool same_cause(const Cause& a, const Cause& b) {
  return effect_of(a) == effect_of(b) && joint_of(a) == joint_of(b) && frame_of(a) == frame_of(b);
}

CauseWords words_of(const Model& arm, const Cause& cause) {
  CauseWords out;
  out.effect = effect_of(cause);
  out.joint = acting_joint(arm, cause);
  out.coordinate = out.joint ? arm.coordinates()[out.joint->value].name : kWholeArm;
  if (const auto frame = frame_of(cause))
    out.frame = arm.frames()[frame->value].name;
  if (const auto* wrong = std::get_if<KinematicError>(&cause)) {
    out.constant = std::visit(Overloaded{[](const NamedConstant& n) { return n.name; },
                                         [&](const FrameConstant& n) { return name_of(arm, n); },
                                         [](JointZero /*n*/) { return std::string(kZero); }},
                              wrong->constant);
  }
  if (const auto* contact = std::get_if<ExternalContact>(&cause)) {
    FrameIndex k;
    while (!arm.moves(k, contact->joint)) ++k.value;
    out.frame = arm.frames()[k.value].name;
  }
  return out;
}

std::vector<std::string> names_of_causes() {
  return {AddedLoad::kName, KinematicError::kName, ExternalContact::kName};
}

}  // namespace veridyn
