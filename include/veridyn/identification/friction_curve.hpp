#pragma once

#include <vector>

#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// Friction of one joint that slides steadily, against its speed: the sum of the model's effects
/// that are friction, at the mean position and the mean square load of the training recordings.
struct FrictionCurve {
  int joint = 0;        ///< from 0
  VectorXd velocity;    ///< [rad/s], [m/s], in growing order, up to the largest recorded speed; never zero
  VectorXd torque;      ///< [N m], [N]
  VectorXd half_width;  ///< of the 95 % interval that the parameters' statistics give [N m], [N]

  /// The torque at a speed, between two points of the curve; its ends beyond them.
  double at(double speed) const;
};

/// Curves of all joints that the training recordings move; none where the model has no friction.
/// @param id  with a model, and with the series of its training recordings.
std::vector<FrictionCurve> friction_curves(const Identification& id);

}  // namespace veridyn
