#pragma once

#include <algorithm>
#include <cmath>

namespace veridyn {

/// The limits of one joint [rad], [m]; infinite if there is none.
struct PositionRange {
  double lower = 0.0, upper = 0.0;
};

/// True if a joint is beyond a limit, or too fast to stop before it: the test of position limits for planned
/// motions and for moving arms. Braking with ddq = -braking dq stops within
///
///   dq / braking
///
/// A joint beyond a limit that moves back inside is allowed; one whose position or velocity is NaN is not.
///
/// @param braking  [1/s], SafetyLimits::braking.
inline bool leaves_range(double q, double dq, const PositionRange& range, double braking) noexcept {
  const double stops = q + dq / braking;
  if (std::isnan(stops)) return true;
  const bool above = std::max(q, stops) > range.upper && dq >= 0.0;
  const bool below = std::min(q, stops) < range.lower && dq <= 0.0;
  return above || below;
}

}  // namespace veridyn
