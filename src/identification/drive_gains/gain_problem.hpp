#pragma once

#include <vector>

#include "veridyn/math/types.hpp"

namespace veridyn {

/// The currents of one joint against the torques that many rows of measurements stand for:
///
///   || p (U x + k) - z ||^2 + rho2        p: one over the drive gain
struct GainEquation {
  MatrixXd U;         ///< (any x unknowns) torque per unknown
  VectorXd k;         ///< torque of what is known
  VectorXd z;         ///< current
  double rho2 = 0.0;  ///< squared current outside the rows
  double rows = 0.0;  ///< Number of measurements
};

/// p_j = scale * ratio_j and x = y / scale: where nothing of the known torque shows, the scale is
/// zero and all else stays finite.
struct GainSolution {
  VectorXd y;          ///< (unknowns) [A] of the reference joint per unit of an unknown
  double scale = 0.0;  ///< p of the reference joint [A/N m]
  VectorXd ratio;      ///< (joints) p over that of the reference joint
  int reference = 0;   ///< joint that feels what is known best
  double cost = 0.0;   ///< weighted sum of squares
  bool converged = false;

  VectorXd p() const { return scale * ratio; }
};

/// A start that needs none: U x + k = K z is linear in x and K. Only the part of the currents that
/// torques can explain is in z, so that noise does not shrink K (two-stage least squares). Where
/// nothing gives K a scale, the ratio is one.
/// @param sigma  (joints) rms noise of the currents, to weight joints with.
GainSolution start_gains(const std::vector<GainEquation>& equations, const VectorRef& sigma);

/// Minimises the sum over joints of (|| p_j (U_j x + k_j) - z_j ||^2 + rho2_j) / sigma_j^2 by
/// Levenberg and Marquardt's method.
GainSolution solve_gains(const std::vector<GainEquation>& equations, const VectorRef& sigma,
                         const GainSolution& start);

/// (joints) share of every ratio's column of the Jacobian (of the scale's, for the reference joint)
/// that the other columns do not span: zero where another gain and other parameters would fit as
/// well.
VectorXd independent_shares(const std::vector<GainEquation>& equations, const VectorRef& sigma,
                            const GainSolution& at);

/// (joints) rms of what a solution leaves of the currents.
VectorXd residual_current(const std::vector<GainEquation>& equations, const GainSolution& at);

}  // namespace veridyn
