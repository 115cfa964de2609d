#pragma once

#include <utility>

#include "control/control_support.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/plausible_model.hpp"

namespace veridyn {

/// The thesis's arm with bodies that could exist and friction as such arms have it: viscous,
/// Coulomb, with a memory, and changing along the insertion.
inline Model psm_like(unsigned seed = 1) {
  const Model arm = plausible_model(read_model("psm-3dof"), seed).arm;
  return with_effects(
      arm, {effect_on(arm, "viscous_friction", 0, {{"coefficient", 0.05}}),
            effect_on(arm, "coulomb_friction", 0, {{"level", 0.10}}),
            effect_on(arm, "presliding_hysteresis", 0, {{"level", 0.08}, {"distance", 0.02}}),
            effect_on(arm, "torque_offset", 0, {{"offset", 0.03}}),
            effect_on(arm, "viscous_friction", 1, {{"coefficient", 0.05}}),
            effect_on(arm, "coulomb_friction", 1, {{"level", 0.15}}),
            effect_on(arm, "presliding_hysteresis", 1, {{"level", 0.12}, {"distance", 0.02}}),
            effect_on(arm, "joint_spring", 1, {{"stiffness", 0.4}}),
            effect_on(arm, "viscous_friction", 2, {{"coefficient", 0.7}}),
            effect_on(arm, "coulomb_friction", 2, {{"level", 0.50}}),
            effect_on(arm, "presliding_hysteresis", 2, {{"level", 0.25}, {"distance", 1.5e-3}}),
            effect_on(arm, "position_dependent_friction", 2,
                      {{"slope", 1.2}, {"curvature", 10.0}, {"centre", 0.12}}),
            effect_on(arm, "rotor_inertia", 2, {{"inertia", 0.3}})});
}

/// The same as a counterbalanced arm, which the real one is: its weight counts for a tenth.
inline Model counterbalanced_psm_like(unsigned seed = 1) {
  ModelDescription description = psm_like(seed).description();
  description.gravity *= 0.1;
  return Model(std::move(description));
}

}  // namespace veridyn
