#pragma once

#include "veridyn/math/types.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// Bounds of a motion for every coordinate, (n) each.
struct MotionLimits {
  VectorXd lower;         ///< [rad] or [m], finite
  VectorXd upper;         ///< finite
  VectorXd velocity;      ///< largest speed, finite
  VectorXd acceleration;  ///< largest acceleration; infinite where the file gives none
};

/// The limits of the robot file. Defaults: 1 rad or 0.1 m to either side of zero (with a single
/// limit: twice as far from it), 2 rad/s or 0.2 m/s, any acceleration.
MotionLimits motion_limits(const Model& arm);

}  // namespace veridyn
