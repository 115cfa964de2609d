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
  VectorXd rest_friction2; ///< (n) square of what dry friction at rest may be
  MatrixXd parts;          ///< (n x 3) sizes of what the model adds up: gravity, the rest of the rigid
                           ///< bodies' torque, effects
  bool follows = true;     ///< false: the step before it is not the one in time
};

}  // namespace veridyn::watching
