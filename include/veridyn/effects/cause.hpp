#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// An effect along an axis that the model does not have.
struct NewEffect {
  std::string effect;
  JointIndex joint;  ///< the axis' main coordinate
};

/// An effect that the model has and whose parameters have changed.
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
  std::optional<JointIndex> joint;  ///< nullopt: an error of the whole arm
};

/// The numbers that determine the pose of a frame in a robot file: those of a DH row, those of a joint's
/// origin as in URDF, and the ratio of a coordinate in the frame's joint variable.
enum class FrameNumber { kA, kAlpha, kD, kTheta, kX, kY, kZ, kRoll, kPitch, kYaw, kRatio };

/// A geometric constant of one frame: a DH parameter, a coordinate of its origin, or a gear ratio.
struct FrameConstant {
  FrameIndex frame;
  FrameNumber number = FrameNumber::kA;
  std::optional<JointIndex> joint = {};  ///< the joint of a ratio
};

/// A constant of the robot file with a name of its own.
struct NamedConstant {
  std::string name;
};

/// The zero of a joint, which shifts every joint variable that contains its coordinate.
struct JointZero {
  JointIndex joint;
};

/// A wrong constant of the robot file.
struct KinematicError {
  static constexpr const char* kName = "coupling_error";
  std::variant<NamedConstant, FrameConstant, JointZero> constant;
};

/// A force from outside the arm, limited in time.
struct ExternalContact {
  static constexpr const char* kName = "external_contact";
  JointIndex joint;
};

/// A possible error of a model, with its place. This one type is used by diagnosis, which finds causes, by
/// excitation, which separates them, and by simulation, which injects them.
///
/// Its text form is EFFECT:PLACE, where PLACE is a joint (name or number from 1), the frame of a
/// load, "arm", or a constant, by its name or after its frame or joint: "backlash:2",
/// "payload:tool", "gravity_tilt:arm", "coupling_error:delta", "coupling_error:elbow.theta".
using Cause = std::variant<NewEffect, ChangedEffect, AddedLoad, AddedInertia, ChannelError,
                           KinematicError, ExternalContact>;

/// Place of a cause that concerns the whole arm.
constexpr const char* kWholeArm = "arm";

/// The two parts of a cause's text form, not yet looked up in an arm.
struct CauseText {
  std::string effect;
  std::string place;  ///< may be empty for a cause of the whole arm
};

/// Splits "EFFECT:PLACE" or "EFFECT" at the first colon, without looking anything up.
CauseText split_cause(const std::string& words);

/// Joins the two parts: "EFFECT:PLACE", or "EFFECT" without a place.
std::string to_text(const CauseText& cause);

/// Resolves the text form of a cause against an arm.
///
/// @param where  beginning of an error message: "excitation: 'backlash:elbw'".
/// @throws InvalidInput  no such effect, joint, frame or constant; the message lists those that
/// exist and suggests a similar name.
Cause find_cause(const Model& arm, const CauseText& cause, const std::string& where);

/// Applies split_cause() and then find_cause().
Cause parse_cause(const Model& arm, const std::string& words);

/// The text form, with the joint's name: "backlash:elbow"; parse_cause() is its inverse.
std::string to_text(const Model& arm, const Cause& cause);

/// The name in files and findings: "backlash", "payload".
std::string effect_of(const Cause& cause);

/// The joint or the frame in the text form of the cause, if any.
std::optional<JointIndex> joint_of(const Cause& cause);
std::optional<FrameIndex> frame_of(const Cause& cause);

/// The joint on which the cause acts. For a load or a number of a frame's row it is the last joint that moves
/// the frame; nullopt: the whole arm.
std::optional<JointIndex> acting_joint(const Model& arm, const Cause& cause);

/// True if both are the same effect at the same joint or frame, whichever constant it concerns; a new effect equals a changed one.
bool same_cause(const Cause& a, const Cause& b);

/// The parts of a cause, for reports.
struct CauseWords {
  std::string effect;
  std::optional<JointIndex> joint;  ///< acting_joint() of the cause; nullopt: the whole arm
  std::string coordinate;  ///< name of that coordinate, or "arm"
  /// Frame of a load or of a frame's row, or the first frame that a contact can act on.
  std::string frame;
  std::string constant;  ///< "theta", "delta"; empty where the cause is no constant
};
CauseWords words_of(const Model& arm, const Cause& cause);

/// Looks up a joint by name or by number from 1. @throws InvalidInput  as find_cause().
JointIndex find_joint(const Model& arm, const std::string& word, const std::string& where);

/// Looks up a frame by name. @throws InvalidInput  as find_cause().
FrameIndex find_frame(const Model& arm, const std::string& word, const std::string& where);

/// Names of the causes that are not effects: loads, wrong constants, contacts.
std::vector<std::string> names_of_causes();

}  // namespace veridyn
