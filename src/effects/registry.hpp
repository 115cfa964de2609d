#pragma once

#include "veridyn/effects/channel_effect.hpp"
#include "veridyn/effects/effect.hpp"

/// The effects of the library in the order of docs/contract.md, in which they are tested and listed. One line
/// per effect: its function is defined in the file of its name, or in one_column.cpp or position_dependent.cpp.
// clang-format off
#define VERIDYN_EFFECTS(EFFECT) \
  EFFECT(rotor_inertia) \
  EFFECT(joint_spring) \
  EFFECT(viscous_friction) \
  EFFECT(coulomb_friction) \
  EFFECT(torque_offset) \
  EFFECT(stribeck_friction) \
  EFFECT(presliding_hysteresis) \
  EFFECT(asymmetric_friction) \
  EFFECT(position_dependent_friction) \
  EFFECT(position_dependent_viscosity) \
  EFFECT(load_dependent_friction) \
  EFFECT(quadratic_drag) \
  EFFECT(sublinear_viscous) \
  EFFECT(torque_ripple) \
  EFFECT(cable_coupling) \
  EFFECT(position_force) \
  EFFECT(backlash) \
  EFFECT(transmission_compliance) \
  EFFECT(torque_gain) \
  EFFECT(torque_drift) \
  EFFECT(time_delay) \
  EFFECT(gravity_tilt) \
  EFFECT(encoder_offset) \
  EFFECT(warm_up) \
  EFFECT(base_compliance) \
  EFFECT(end_stop) \
  EFFECT(tip_force) \
  EFFECT(torque_crosstalk) \
  EFFECT(tabulated_force)
// clang-format on

namespace veridyn {

#define VERIDYN_DECLARE_EFFECT(name) const Effect& name();
VERIDYN_EFFECTS(VERIDYN_DECLARE_EFFECT)
#undef VERIDYN_DECLARE_EFFECT

}  // namespace veridyn
