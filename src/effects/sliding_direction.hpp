#pragma once

#include <algorithm>

#include "veridyn/effects/effect.hpp"

namespace veridyn {

/// The sign of a velocity, in [-1, 1].
///
/// A joint at rest has no direction, and the sign of its velocity noise would be a random torque.
/// Below kRestSpeed the sign is therefore linear.
inline double sliding_direction(double ds) noexcept {
  return std::clamp(ds / kRestSpeed, -1.0, 1.0);
}

}  // namespace veridyn
