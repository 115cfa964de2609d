#include "kinematics/motion_limits.hpp"

#include <cmath>

namespace veridyn {

MotionLimits motion_limits(const Model& arm) {
  const int n = arm.joints();
  MotionLimits out{VectorXd(n), VectorXd(n), VectorXd(n), VectorXd(n)};
  for (int i = 0; i < n; ++i) {
    const Coordinate& coordinate = arm.coordinates()[i];
    const Limits& limits = coordinate.limits;
    const double reach = coordinate.prismatic ? 0.1 : 1.0;
    const bool has_lower = std::isfinite(limits.lower);
    const bool has_upper = std::isfinite(limits.upper);
    out.lower[i] = has_lower ? limits.lower : has_upper ? limits.upper - 2.0 * reach : -reach;
    out.upper[i] = has_upper ? limits.upper : has_lower ? limits.lower + 2.0 * reach : reach;
    out.velocity[i] = std::isfinite(limits.velocity) ? limits.velocity : 2.0 * reach;
    out.acceleration[i] = limits.acceleration;
  }
  return out;
}

}  // namespace veridyn
