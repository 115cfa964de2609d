#pragma once

#include <string>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// Names of the effects of plain friction.
constexpr const char* kPlainViscous = "viscous_friction";
constexpr const char* kPlainCoulomb = "coulomb_friction";
constexpr const char* kPlainOffset = "torque_offset";

/// Name of the effect that is added on geared joints.
constexpr const char* kRotorInertia = "rotor_inertia";
constexpr const char* kJointSpring = "joint_spring";

/// True if no effect of the arm is friction, as in most manufacturers' files.
bool has_no_friction(const Model& arm);

/// Adds viscous friction, Coulomb friction and a torque offset, without values, on every coordinate that does
/// not have them.
Model with_plain_friction(const Model& arm);

/// Adds one effect, without values, on every coordinate that does not have it.
Model with_effect_of_all_joints(const Model& arm, const std::string& effect);

}  // namespace veridyn
