#pragma once

#include <algorithm>

#include "veridyn/control/computed_torque.hpp"

namespace veridyn::dvrk {

/// A smooth path from the arm's position to the start of the motion.
struct Approach {
  VectorXd from, to;
  double duration = 0.0;

  void at(double t, JointReference& point) const noexcept {
    const double s = std::clamp(t / duration, 0.0, 1.0);
    const double a = s * s * s * (10.0 - s * (15.0 - 6.0 * s));
    const double da = 30.0 * s * s * (1.0 - s) * (1.0 - s) / duration;
    const double dda = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / (duration * duration);
    point.q = from + a * (to - from);
    point.dq = da * (to - from);
    point.ddq = dda * (to - from);
  }
};

}  // namespace veridyn::dvrk
