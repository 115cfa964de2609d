#pragma once

#include "veridyn/math/types.hpp"

namespace veridyn::watching {

/// Means over a step of a tenth of a second.
struct Step {
  double time = 0.0;       ///< [s] its middle
  VectorXd residual;       ///< (n) measured minus modelled torque
  VectorXd torque;         ///< (n) measured
  VectorXd position;       ///< (n) [rad], [m] at its end
  MatrixXd columns;        ///< (n x hypotheses) torque per unit of each hypothesis
  VectorXd rest_friction2; ///< (n) squared bound of dry friction at rest
  /// (n x 3) magnitudes of the model's components: gravity, the other torque of the rigid bodies,
  /// effects.
  MatrixXd parts;
  bool follows = true;     ///< false: the previous step is not adjacent in time
};

}  // namespace veridyn::watching
