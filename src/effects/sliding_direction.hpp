#pragma once

#include <algorithm>

#include "veridyn/effects/effect.hpp"

namespace veridyn {

/// The sign of a velocity, in [-1, 1].
///
/// A resting joint has no direction: the sign of its velocity noise would be a fast random torque.
/// Below kRestSpeed the sign is a straight line through zero.
inline double sliding_direction(double ds) noexcept {
  return std::clamp(ds / kRestSpeed, -1.0, 1.0);
}

}  // namespace veridyn
