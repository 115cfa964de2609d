#pragma once

#include <vector>

#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// Friction of one joint in steady sliding as a function of speed: the sum of the model's friction
/// effects, at the mean position and the mean square load of the training recordings.
struct FrictionCurve {
  JointIndex joint;
  VectorXd velocity;    ///< [rad/s], [m/s], increasing, up to the largest recorded speed; never zero
  VectorXd torque;      ///< [N m], [N]
  VectorXd half_width;  ///< half width of the 95 % interval from the parameters' statistics [N m], [N]

  /// The torque at a speed, interpolated between two points of the curve, and constant beyond its ends.
  double at(double speed) const;
};

/// Computes the curves of all joints that move in the training recordings; empty if the model has
/// no friction.
/// @param id  must hold a model and the series of its training recordings.
std::vector<FrictionCurve> friction_curves(const Identification& id);

}  // namespace veridyn
