#pragma once

#include <string>

namespace veridyn {

/// What a controller makes of an effect.
enum class EffectKind {
  kInertia,   ///< part of the mass matrix
  kFriction,  ///< opposes the motion: FrictionCompensation
  kForce,     ///< any other torque of position and velocity: part of ArmState::bias()
  kLeftOut    ///< counted from the start of a recording, or of measured motion only
};

/// @throws InvalidInput  an effect that has no place here yet.
EffectKind effect_kind(const std::string& effect);

}  // namespace veridyn
