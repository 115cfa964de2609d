#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// Index of a generalized coordinate, from 0. People read its name or its number from 1.
struct JointIndex {
  int value = 0;
};

/// Index of a frame in Model::frames().
struct FrameIndex {
  int value = 0;
};

inline bool operator==(JointIndex a, JointIndex b) {
  return a.value == b.value;
}
inline bool operator!=(JointIndex a, JointIndex b) {
  return a.value != b.value;
}
inline bool operator==(FrameIndex a, FrameIndex b) {
  return a.value == b.value;
}
inline bool operator!=(FrameIndex a, FrameIndex b) {
  return a.value != b.value;
}

/// An effect along an axis that the model does not have.
struct NewEffect {
  std::string effect;
  JointIndex joint;  ///< the axis' main coordinate
};

/// An effect that the model has and whose parameters are no longer what they were.
struct ChangedEffect {
  std::string effect;
  JointIndex joint;
};

/// A load on a link.
struct AddedLoad {
  static constexpr const char* kName = "payload";
  FrameIndex frame;
};

/// Moments of inertia on a link, without mass.
struct AddedInertia {
  static constexpr const char* kName = "inertia";
  FrameIndex frame;
};

/// An error of a recorded signal or of the base, see ChannelEffect.
struct ChannelError {
  std::string effect;
  std::optional<JointIndex> joint;  ///< nothing: of the whole arm
};

/// A constant of the robot file that is wrong: one that has a name there, a number of a frame's row
/// ("theta", "alpha", "a", "d", "ratio of pitch"), or the zero of a joint ("zero").
struct KinematicError {
  static constexpr const char* kName = "coupling_error";
  static constexpr const char* kZero = "zero";
  std::string constant;
  /// Whose number it is; nothing: it has a name of its own.
  std::variant<std::monostate, FrameIndex, JointIndex> of = {};
};

/// A push from outside, limited in time.
struct ExternalContact {
  static constexpr const char* kName = "external_contact";
  JointIndex joint;
};

/// One thing that may be wrong with a model, at its place. The same type is what a diagnosis finds,
/// what an excitation is to tell from another, and what a simulation injects.
///
/// Its text form is EFFECT:PLACE, where PLACE is a joint (name or number from 1), the frame of a
/// load, "arm", or a constant, by its name or after its frame or joint: "backlash:2",
/// "payload:tool", "gravity_tilt:arm", "coupling_error:delta", "coupling_error:elbow.theta".
using Cause = std::variant<NewEffect, ChangedEffect, AddedLoad, AddedInertia, ChannelError,
                           KinematicError, ExternalContact>;

/// The place of a cause of the whole arm.
constexpr const char* kWholeArm = "arm";

/// The two parts of a cause's text form, not yet looked up in an arm.
struct CauseText {
  std::string effect;
  std::string place;  ///< may be empty where the whole arm is meant
};

/// Splits "EFFECT:PLACE" or "EFFECT" at the first colon; knows no names.
CauseText split_cause(const std::string& words);

/// "EFFECT:PLACE", or "EFFECT" where there is no place.
std::string to_text(const CauseText& cause);

/// Looks a cause up in an arm.
///
/// @param where  what an error message begins with: "excitation: 'backlash:elbw'".
/// @throws InvalidInput  no such effect, joint, frame or constant; with what there is and, where a
///                       name is near, a suggestion.
Cause find_cause(const Model& arm, const CauseText& cause, const std::string& where);

/// split_cause() and find_cause().
Cause parse_cause(const Model& arm, const std::string& words);

/// The text form, with the joint's name: "backlash:elbow". parse_cause() reads it back.
std::string to_text(const Model& arm, const Cause& cause);

/// The name in files and findings: "backlash", "payload".
std::string effect_of(const Cause& cause);

/// The joint or the frame it is about, where it has one.
std::optional<JointIndex> joint_of(const Cause& cause);
std::optional<FrameIndex> frame_of(const Cause& cause);

/// Where it acts: its joint; of a load and of a number of a frame's row the last joint that moves
/// the frame; nothing: on the whole arm.
std::optional<JointIndex> acting_joint(const Model& arm, const Cause& cause);

/// True if they are of one name at one joint or frame: a new effect and a changed one are.
bool alike(const Cause& a, const Cause& b);

/// A cause in the words that reports are made of.
struct CauseWords {
  std::string effect;
  int joint = 0;           ///< number of acting_joint() from 1; 0: the whole arm
  std::string coordinate;  ///< its name; "arm"
  std::string frame;       ///< of a load, a frame's row, or the first one that a contact can be on
  std::string constant;    ///< "theta", "delta"; empty where it is none
};
CauseWords words_of(const Model& arm, const Cause& cause);

/// Joint by name or by number from 1. @throws InvalidInput  as find_cause().
JointIndex find_joint(const Model& arm, const std::string& word, const std::string& where);

/// Frame by name. @throws InvalidInput  as find_cause().
FrameIndex find_frame(const Model& arm, const std::string& word, const std::string& where);

/// Names of causes that are no effects and that files and commands know: loads, wrong constants,
/// contacts.
std::vector<std::string> names_of_causes();

}  // namespace veridyn
