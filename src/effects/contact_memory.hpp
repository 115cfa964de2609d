#pragma once

#include <algorithm>
#include <cmath>

#include "sliding_direction.hpp"
#include "veridyn/effects/effect.hpp"
#include "effects/written_in_c.hpp"

namespace veridyn {

/// Displacement since the previous sample, 0 at the first one. Uses state[1] and state[2].
inline double step_since_last(double s, EffectState& state) noexcept {
  const double step = state[2] != 0.0 ? s - state[1] : 0.0;
  state[1] = s;
  state[2] = 1.0;
  return step;
}

/// Shear z in [-1, 1] of a contact, which depends on the path and not on the speed along it:
///
///   dz/ds = (1 - sgn(ds) z) / distance
///
/// solved exactly over each step for a straight path between samples:
///
///   z <- z + (sgn(step) - z) (1 - exp(-|step| / distance))
///
/// z is state[0]. Source: Dahl, A Solid Friction Model, Aerospace Corporation, 1968, with
/// exponent 1.
inline double advance_contact(double s, double distance, EffectState& state) noexcept {
  const double step = step_since_last(s, state);
  const double side = step < 0.0 ? -1.0 : 1.0;
  state[0] -= (side - state[0]) * std::expm1(-std::abs(step) / distance);
  state[0] = std::clamp(state[0], -1.0, 1.0);  // removes rounding errors
  return state[0];
}

/// Direction of friction: the sign of the velocity, or with a distance above zero the shear of the
/// contact, which is valid at rest and at reversals too.
inline double friction_direction(const AxisSample& x, double distance,
                                 EffectState& state) noexcept {
  return distance > 0.0 ? advance_contact(x.s, distance, state) : sliding_direction(x.ds);
}

/// friction_direction() as C, see WrittenInC.
inline std::string c_friction_direction(double distance) {
  return distance > 0.0 ? "@contact(s, " + c_number(distance) + ", z)" : "@direction(ds)";
}

}  // namespace veridyn
