#pragma once

// Private to feasible_least_squares.

#include "identification/feasible/cone_program.hpp"
#include "identification/feasible/nesterov_todd.hpp"

namespace veridyn::cone {

struct Stop {
  double gap_tolerance = 1e-9;
  double cost_floor = 0.0;  ///< gaps are relative to max(cost, cost_floor); > 0
  int max_iterations = 100;
};

struct Solution {
  FeasibleStatus status = FeasibleStatus::kNotConverged;
  Point point;        ///< feasible point with the smallest gap, or the last point if there was none
  VectorXd interior;  ///< first strictly feasible x, well inside; empty if there was none
  std::vector<int> unbounded_columns;
  int iterations = 0;
};

/// Initial point: x of plausible size, slacks and multipliers well inside their cones.
struct Start {
  VectorXd x;
  VectorXd slack;
  VectorXd lambda;
  std::vector<ScaledBlock> blocks;
};

/// @param hessian    2*R'*R, lower triangle.
/// @param first_gap  expected duality gap relative to the cost of the first x; a larger one favours
/// feasibility over the cost.
Start starting_point(const Program& program, const MatrixXd& hessian, double cost_floor,
                     double first_gap);

/// Primal-dual predictor-corrector method with the Nesterov-Todd direction from an infeasible
/// start.
///
/// The method is invariant to units: directions and step lengths do not change when variables or
/// constraints are scaled, so nothing is scaled beforehand.
Solution solve(const Program& program, const Stop& stop);

}  // namespace veridyn::cone
