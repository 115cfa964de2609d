#pragma once

#include <string>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// Reads an arm from an MJCF file of MuJoCo: a frame for every body and every named site, a
/// coordinate for every hinge and slide that follows no other joint, in the order of the file.
///
/// Read are defaults of classes; poses in all five notations; `inertial`, or else the inertia of
/// primitive geoms as the compiler infers it; joints with range, ref, damping (viscous_friction),
/// frictionloss (coulomb_friction), armature (rotor_inertia), stiffness (joint_spring); couplings by
/// `equality` of joints or fixed tendons; the largest force of actuators; a constant bias of an
/// actuator (torque_offset). Contacts, sensors, assets, controllers and appearance are ignored.
/// @throws InvalidInput  no such file, no valid MJCF, or a part that changes the dynamics and is
/// not known here: free and ball joints, closed chains, included files, inertia inferred from
/// meshes, gravity compensation, a medium.
Model read_mjcf(const std::string& path);

/// Reads an arm from an SDFormat file with one model: a frame for every link, a coordinate for
/// every revolute, continuous or prismatic joint that mimics no other, in the order of the file.
///
/// Poses may be relative to any link, joint or frame, in the notations up to SDFormat 1.11; limits,
/// effort, velocity; damping (viscous_friction), friction (coulomb_friction), spring_stiffness
/// (joint_spring). Plugins, sensors and appearance are ignored.
/// @throws InvalidInput  no such file, no valid SDFormat, included or nested models, closed chains,
/// other types of joints.
Model read_sdf(const std::string& path);

}  // namespace veridyn
