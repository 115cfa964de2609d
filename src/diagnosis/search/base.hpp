#pragma once

#include <vector>

#include "diagnosis/search/rows.hpp"

namespace veridyn::search {

/// Columns of the arm's own parameters, which are part of every fit: directions u that the rows determine,
///
///   values = values of the arm + T u.
///
/// For a MODEL u is whitened by its covariance, so that its prior is |u|^2 / 2.
struct Base {
  MatrixXd T;               ///< (parameters x directions)
  std::vector<MatrixXd> X;  ///< (rows x directions) of every joint
  VectorXd ridge;           ///< ridge of every direction
  bool prior = false;
  Eigen::Index hidden = 0;  ///< number of directions, the last ones, whose torque is zero under the MODEL's gravity but not under another
  /// Friction levels that cannot be negative: value + row . u >= 0. Empty for a MODEL, whose prior bounds
  /// them.
  MatrixXd nonnegative;
  VectorXd value;
};

/// Columns of the directions T at other rows of the same arm.
MatrixXd base_columns(const Rows& rows, int joint, const MatrixXd& T);

/// Base of an arm with fitted values, with at most `most` directions: errors in the signals can make
/// dependent columns look independent.
Base fitted_base(const Rows& rows, Eigen::Index most, int threads = 1);

/// Covariance of values from their scatter F over clusters of rows (values x clusters) and the Gram matrix G
/// of their columns:
///
///   F F' + (G / noise + D^-1)^-1
///
/// A few clusters scatter in a few directions only. In all others the values are as uncertain as the noise
/// makes them, which is equal for all directions of torque; D bounds undetermined directions by a part of
/// each value's own variance.
MatrixXd covariance_of(const MatrixXd& F, const MatrixXd& G);

/// Base of a MODEL at rows of its own arm: its parameters vary by their covariance, friction and offsets as
/// they do from day to day, and undetermined parameters freely.
Base prior_base(const Rows& rows, const Model& model);

}  // namespace veridyn::search
