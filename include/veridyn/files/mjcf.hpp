#pragma once

#include <map>
#include <string>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// MuJoCo's XML of an arm with values: mj_inverse() returns M(q) ddq + C(q, dq) dq + g(q) of the
/// same bodies, plus the friction, springs and rotors that MuJoCo can represent.
///
/// Every frame that moves or carries a body becomes a body, and every frame a site of its name. The
/// first joint that equals a coordinate has the coordinate's name; other joints are named after
/// their frame ("FRAME__joint"), and where their variable is c . q a fixed tendon with an equality
/// constraint couples them. A coordinate without a joint of its own gets one on a body of 1e-12 kg.
/// For such an arm the torque of coordinate i is the sum of c_i times qfrc_inverse over all joints.
/// Every coordinate has a motor of its name.
///
/// viscous_friction becomes damping, coulomb_friction frictionloss, rotor_inertia armature and
/// joint_spring stiffness: on the coordinate's joint; along several coordinates on a tendon, a rotor
/// on the joint that moves like it or else on a joint of its own ("rotor_1__joint"), coupled like
/// the others. Constants (torque_offset) act through the motors: force = control - constant.
/// Whatever MuJoCo cannot represent (other effects, drive gains) is omitted, and comments say so.
/// Bodies are exported unchanged; see portable_model() for values that were not identified.
/// @throws InvalidInput  a body has no values, or values that MuJoCo refuses (a mass below zero,
/// principal moments that violate the triangle inequality).
///
/// @param remarks  comments on links, by the name of their frame; "" for the whole file.
std::string to_mjcf(const Model& arm, const std::map<std::string, std::string>& remarks = {});

}  // namespace veridyn
