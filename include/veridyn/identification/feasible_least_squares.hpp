#pragma once

#include <string>
#include <vector>

#include "veridyn/identification/pseudo_inertia.hpp"
#include "veridyn/math/types.hpp"

namespace veridyn {

/// Least squares under physical consistency:
///
///   minimise    ||R*x - z||^2 + rho2
///   subject to  J_k(x) positive semidefinite for every body k,   G*x <= h
///
/// R (rows x n) may have any shape and rank; pass the (n x n) square-root factor of long recordings, since every
/// iteration multiplies by R. rho2 is the part of the sum of squares outside the factor.
struct FeasibleProblem {
  MatrixXd R;                     ///< (rows x n)
  VectorXd z;                     ///< (rows)
  double rho2 = 0.0;              ///< >= 0, in the unit of z squared
  std::vector<int> body_columns;  ///< first of a body's ten columns, in the order of InertialVector
  MatrixXd G;                     ///< (m x n), or empty: no bounds
  VectorXd h;                     ///< (m)
};

/// Condition for the physical consistency of a body.
enum class PhysicalCondition {
  /// pseudo_inertia(phi) >= 0: necessary and sufficient for a positive mass distribution.
  kPseudoInertia,
  /// I >= 0 and m >= 0, I about the origin of the frame, h ignored: weaker (necessary only),
  /// offered to compare with older work
  kPrincipalMoments,
  kNone               ///< only G*x <= h
};

/// Entropic prior of body k: adds weight * entropic_divergence(J_k, J(phi)).
struct EntropicPrior {
  double weight = 0.0;              ///< > 0 (in the unit of z squared), or 0: none
  /// One per body, pseudo-inertia positive definite; zeros: no prior.
  std::vector<InertialVector> phi;
};

/// Quadratic prior: adds the sum of weight_j * (x_j - x0_j)^2.
struct QuadraticPrior {
  VectorXd weight;  ///< (n), >= 0, or empty: none
  VectorXd x;       ///< (n)
};

struct FeasibleOptions {
  PhysicalCondition condition = PhysicalCondition::kPseudoInertia;
  /// Converged when  cost - lower_bound <= gap_tolerance * max(cost, floor), floor = 1e-4*(||z||^2
  /// + rho2), so that data fitted exactly can converge. If z and rho2 are zero, floor =
  /// 1e-10*||R||_F^2; a heavy entropic prior raises it to the rounding of its terms.
  double gap_tolerance = 1e-9;
  /// Every J_k (or the matrix of the chosen condition) keeps eigenvalues > margin; SI units, >= 0.
  double eigenvalue_margin = 0.0;
  /// A row of G is active when
  /// h_i - G_i*x <= active_tolerance * (|h_i| + sum_j |G_ij| * max(|x_j|, w_j)),  w_j the smaller
  /// of ||z||/||R_j|| and the width of the interval that the bounds leave to x_j; a body when
  /// smallest_scaled_eigenvalue(J_k - margin*1) <= active_tolerance.
  double active_tolerance = 1e-6;
  int max_iterations = 100;  ///< limit per attempt; up to three attempts if no feasible point is met
  EntropicPrior entropic_prior;
  QuadraticPrior quadratic_prior;
};

enum class FeasibleStatus {
  kOptimal,      ///< x is strictly feasible and the gap is within the tolerance
  kInfeasible,   ///< no x satisfies all constraints; `certificate` is the basis of this statement
  /// The feasible set has no interior (as with x <= 1 and x >= 1); x satisfies the constraints up
  /// to rounding.
  kNoInterior,
  /// The gap is above the tolerance after the last iteration; x is the best found, see `feasible`. Also
  /// where the cost has no minimum because parameters that neither data nor bounds limit grow without
  /// end; `unbounded_columns` lists those without bounds.
  kNotConverged
};

/// Basis of the lower bound, or of the status kInfeasible.
enum class Certificate {
  kRigorous,  ///< weak duality; dual residuals and rounding multiplied by bounds that follow from
              ///< G, h and J >= 0
  /// some parameter has no such bound; its |x_j| was assumed below 2*|x_j| + ||z||/||R_j|| (2*|x_j| if column
  /// R_j is zero). See `unbounded_columns`.
  kNoBox
};

/// An active row of G.
struct ActiveRow {
  int row = 0;
  double slack = 0.0;       ///< h_i - G_i*x > 0
  double multiplier = 0.0;  ///< d cost / d h_i = -multiplier
};

/// A body at the boundary of physical consistency.
struct ActiveBody {
  int body = 0;                    ///< index into body_columns
  double scaled_eigenvalue = 0.0;  ///< smallest_scaled_eigenvalue of its matrix minus the margin
  Eigen::Vector4d eigenvalues;     ///< eigenvalues of its matrix, ascending
  Eigen::Matrix4d multiplier;      ///< Z_k >= 0: d cost = <Z_k, d(margin*1)>
};

struct FeasibleResult {
  FeasibleStatus status = FeasibleStatus::kNotConverged;
  VectorXd x;                ///< (n)
  bool feasible = false;     ///< checked afterwards with plain eigenvalues and G*x < h, strictly
  double objective = 0.0;    ///< ||R*x - z||^2 + rho2 at x
  double cost = 0.0;         ///< objective plus the terms of the priors: the minimised function
  /// Lower bound of the cost over all feasible points; infinity if there are none.
  double lower_bound = 0.0;
  double duality_gap = 0.0;  ///< (cost - lower_bound) / max(cost, floor)
  Certificate certificate = Certificate::kNoBox;
  std::vector<int> unbounded_columns;  ///< columns without a bound, see Certificate::kNoBox
  std::vector<ActiveRow> active_rows;
  std::vector<ActiveBody> active_bodies;
  VectorXd row_multipliers;  ///< (m), >= 0
  /// Z_k >= 0, one per body; zero without a condition, or where an entropic prior alone keeps the
  /// body consistent.
  std::vector<Eigen::Matrix4d> body_multipliers;
  int iterations = 0;
  double seconds = 0.0;

  /// A few lines of text: status, objective, gap, active constraints.
  std::string report() const;
};

/// Solves the problem by a primal-dual interior-point method (Nesterov-Todd direction,
/// predictor-corrector, infeasible start). Where the data do not determine x, the solution lies
/// near the analytic centre of the optimal set and can be far out in directions that neither data
/// nor bounds limit; a prior limits them. The problem is bounded, since the cost is at least rho2.
///
/// First-order conditions of the multipliers lambda and Z_k, without priors:
///
///   2*R'*(R*x - z) + G'*lambda - sum_k adjoint(Z_k) = 0
///   lambda_i*(h_i - G_i*x) = 0,   J_k*Z_k = 0,   lambda >= 0,   Z_k >= 0
///
/// Source: Todd, Toh and Tutuncu, SIAM J. Optim. 8(3), 1998; Sousa and Cortesao, IJRR 33(6), 2014.
/// Cost: 2*rows*n^2 once, n^3/3 + O(rows*n) per iteration, 10 to 25 iterations. Thread-safe; one
/// thread.
///
/// @throws InvalidInput  sizes that do not fit, entries that are not finite, bodies that overlap,
///                       a prior that is not positive definite, negative tolerances.
FeasibleResult solve_feasible_least_squares(const FeasibleProblem& problem,
                                            const FeasibleOptions& options = {});

}  // namespace veridyn
