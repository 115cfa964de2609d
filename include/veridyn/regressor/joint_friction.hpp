#pragma once

#include <string>
#include <vector>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// Which friction of the joints is part of an arm that is identified, diagnosed or excited. Every
/// real joint has some, and makers' files seldom do.
enum class JointFriction {
  kAuto,   ///< kPlain for a file whose values are a prior (URDF) and which has no friction, else kFile
  kPlain,  ///< viscous and Coulomb friction and a torque offset of every joint
  kFile,   ///< what the robot file has
};

/// "auto", "plain", "file".
const char* name_of(JointFriction friction);

/// The arm with the friction that is asked for. Plain friction comes with the rotor inertia of those
/// joints on which the torques of the arm can tell it from the inertia of the links.
Model with_friction(const Model& arm, JointFriction friction);

/// The same without the rotor inertia that with_friction() adds: recordings that cannot tell it
/// may still tell the rest.
Model with_friction_alone(const Model& arm, JointFriction friction);

/// A sentence on what with_friction() did to an arm, or could have done; empty where the file has
/// friction of its own.
std::string friction_remark(const Model& file, const Model& arm);

/// One number of a joint: friction, offset or rotor inertia.
struct JointNumber {
  std::string effect;
  std::string parameter;
  std::string unit;
  int joint = 0;  ///< from 0
  double value = 0.0;
  double deviation = 0.0;  ///< NaN where it is not known
};

/// Those effects of an arm with values that with_friction() would have added, joint by joint.
std::vector<JointNumber> plain_friction_of(const Model& arm);

}  // namespace veridyn
