#pragma once

// Private to feasible_least_squares.

#include "identification/feasible/cone_program.hpp"

namespace veridyn::cone {

/// Slack and multiplier of one 4x4 block, with the scaling that makes them the same diagonal
/// matrix:
///
///   to_scaled * S * to_scaled' = from_scaled' * Z * from_scaled = diag(d),
///   from_scaled = inv(to_scaled)
///
/// Source: Nesterov and Todd, SIAM J. Optim. 8(2), 1998; computed as in Todd, Toh and Tutuncu,
/// 8(3), 1998.
struct ScaledBlock {
  using Matrix4d = Eigen::Matrix4d;

  Matrix4d S = Matrix4d::Zero();
  Matrix4d Z = Matrix4d::Zero();
  Matrix4d residual = Matrix4d::Zero();  ///< A(x) - margin*1 - S
  bool follows_x = false;                ///< residual is zero and S is computed from x

  Matrix4d to_scaled = Matrix4d::Zero();
  Matrix4d from_scaled = Matrix4d::Zero();
  Matrix4d P = Matrix4d::Zero();  ///< to_scaled' * to_scaled:  P*S*P = Z
  Eigen::Vector4d d = Eigen::Vector4d::Zero();

  /// The current direction, a solution of S*Z = target*1 linearised, and the same in scaled
  /// coordinates. It is affine in dx:  dS = residual + A(dx),  dZ = constant - P*A(dx)*P.
  Matrix4d dS = Matrix4d::Zero();
  Matrix4d dZ = Matrix4d::Zero();
  Matrix4d scaled_dS = Matrix4d::Zero();
  Matrix4d scaled_dZ = Matrix4d::Zero();

  /// Updates the scaling. @returns false if S or Z is not positive definite.
  bool scale();

  /// Sets the direction for dx = 0. @param second_order  true: with the present one's second-order term.
  void begin_direction(double target, bool second_order);
  /// Adds the part of the direction that is linear in dx. @param moved  A(change of dx).
  void advance_direction(const Matrix4d& moved);
};

/// The quadratic form <A(phi), P*A(phi)*P> over the ten variables of a block with the given map.
Matrix10 block_hessian(const Matrix10& map, const Eigen::Matrix4d& P);

/// Norm of a change relative to a positive definite matrix, || inv(L)*change*inv(L)' ||, L*L' = S;
/// below 1, S + change is positive definite. @returns infinity if S is not positive definite.
double relative_norm(const Eigen::Matrix4d& S, const Eigen::Matrix4d& change);

/// True if diag(d) + step*direction is positive definite: twenty times as fast as longest_step().
bool stays_positive(const Eigen::Vector4d& d, const Eigen::Matrix4d& direction, double step);

/// Largest step that keeps diag(d) + step*direction positive semidefinite; d > 0.
double longest_step(const Eigen::Vector4d& d, const Eigen::Matrix4d& direction);

/// Largest step that keeps value + step*direction >= 0; value > 0.
double longest_step(const VectorXd& value, const VectorXd& direction);

inline Eigen::Matrix4d symmetric_part(const Eigen::Matrix4d& A) {
  return 0.5 * (A + A.transpose());
}

}  // namespace veridyn::cone
