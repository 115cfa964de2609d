#pragma once

#include <string>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// What plain friction is made of, by the names of its effects.
constexpr const char* kPlainViscous = "viscous_friction";
constexpr const char* kPlainCoulomb = "coulomb_friction";

/// What a geared joint has beside it.
constexpr const char* kRotorInertia = "rotor_inertia";

/// True if no effect of the arm is friction. Makers' files seldom have any, and every real joint
/// does.
bool has_no_friction(const Model& arm);

/// The arm with what every joint has: viscous friction, Coulomb friction and a torque offset on
/// every coordinate that does not have them yet, without values.
Model with_plain_friction(const Model& arm);

/// The arm with one effect on every coordinate that does not have it yet, without values.
Model with_effect_of_all_joints(const Model& arm, const std::string& effect);

}  // namespace veridyn
