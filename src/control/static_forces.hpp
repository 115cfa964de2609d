#pragma once

#include <vector>

#include "veridyn/effects/effect.hpp"
#include "veridyn/math/types.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// Role of an effect in a controller.
enum class ControlPart {
  kInertia,   ///< part of the mass matrix
  kFriction,  ///< opposes the motion: FrictionCompensation
  kForce,     ///< any other torque of position and velocity: part of ArmState::bias()
  kLeftOut    ///< depends on the time since the start of a recording, or on measured motion only
};

ControlPart control_part(const EffectTraits& traits);  ///< the part of a control law that an effect belongs to

/// The effects of a model that are neither friction nor inertia. @throws InvalidInput  one has no
/// values.
std::vector<BoundEffect> static_forces(const Model& arm);

/// Adds the torques of these effects. @param rest  (n) zeros.
void add_forces(std::vector<BoundEffect>& forces, const VectorRef& q, const VectorRef& dq,
                const VectorRef& rest, VectorXd& tau) noexcept;

/// The inertial parameters of all bodies. @throws InvalidInput  a body has no values; the message
/// begins with `where`.
VectorXd control_parameters(const Model& arm, const char* where);

}  // namespace veridyn
