#pragma once

#include <string>
#include <vector>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// Friction model of the joints for identification, diagnosis and excitation. Every real joint has
/// friction, and manufacturers' files seldom contain it.
enum class JointFriction {
  /// kPlain for a file without friction whose values are a prior (URDF, MJCF, SDF); else kFile.
  kAuto,
  kPlain,  ///< viscous and Coulomb friction and a torque offset of every joint
  kFile,   ///< only the friction of the robot file
};

/// "auto", "plain", "file".
const char* name_of(JointFriction friction);

/// The arm with the chosen friction. Plain friction includes the rotor inertia of those joints
/// where torques can separate it from the inertia of the links.
Model with_friction(const Model& arm, JointFriction friction);

/// Like with_friction() without the added rotor inertia, for recordings that cannot identify it.
Model with_friction_alone(const Model& arm, JointFriction friction);

/// A sentence on the friction that with_friction() has added, or could have added; empty if the file has
/// friction.
std::string friction_remark(const Model& file, const Model& arm);

/// One number of a joint: friction, offset or rotor inertia.
struct JointNumber {
  std::string effect;
  std::string parameter;
  std::string unit;
  JointIndex joint;
  double value = 0.0;
  double deviation = 0.0;  ///< standard deviation; NaN where unknown
};

/// Parameters of those effects that with_friction() would have added, joint by joint, of an arm
/// with values.
std::vector<JointNumber> plain_friction_of(const Model& arm);

}  // namespace veridyn
