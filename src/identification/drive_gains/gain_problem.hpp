#pragma once

#include <vector>

#include "veridyn/math/types.hpp"

namespace veridyn {

/// The currents of one joint as a function of the torques, for any number of measurements:
///
///   || p (U x + k) - z ||^2 + rho2        p: one over the drive gain
struct GainEquation {
  MatrixXd U;         ///< (any x unknowns) torque per unknown
  VectorXd k;         ///< torque of known parameters
  VectorXd z;         ///< current
  double rho2 = 0.0;  ///< squared current outside the rows
  double rows = 0.0;  ///< Number of measurements
};

/// Solution p_j = scale * ratio_j, x = y / scale. If no known torque is identifiable, the scale is zero and
/// all other values remain finite.
struct GainSolution {
  VectorXd y;          ///< (unknowns) current [A] of the reference joint per unit of an unknown
  double scale = 0.0;  ///< p of the reference joint [A/N m]
  VectorXd ratio;      ///< (joints) p over that of the reference joint
  int reference = 0;   ///< joint with the largest known torque relative to its noise
  double cost = 0.0;   ///< weighted sum of squares
  bool converged = false;

  VectorXd p() const { return scale * ratio; }
};

/// Initial values without a guess: U x + k = K z is linear in x and K. z contains only the part of the
/// currents that torques can explain, so that noise does not bias K towards zero (two-stage least squares).
/// The ratio of a joint without a determined K is one.
/// @param sigma  (joints) rms noise of the currents, as weights.
GainSolution start_gains(const std::vector<GainEquation>& equations, const VectorRef& sigma);

/// Minimises the sum over joints of (|| p_j (U_j x + k_j) - z_j ||^2 + rho2_j) / sigma_j^2 by
/// Levenberg and Marquardt's method.
GainSolution solve_gains(const std::vector<GainEquation>& equations, const VectorRef& sigma,
                         const GainSolution& start);

/// (joints) share of every ratio's column of the Jacobian (for the reference joint: of the scale's column)
/// outside the span of the others: zero if another gain with other parameters would fit equally well.
VectorXd independent_shares(const std::vector<GainEquation>& equations, const VectorRef& sigma,
                            const GainSolution& at);

/// (joints) rms residual of the currents.
VectorXd residual_current(const std::vector<GainEquation>& equations, const GainSolution& at);

}  // namespace veridyn
