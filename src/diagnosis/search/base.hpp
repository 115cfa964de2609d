#pragma once

#include <vector>

#include "diagnosis/search/rows.hpp"

namespace veridyn::search {

/// The columns that every set has: the arm's own parameters, reduced to directions u that the rows determine,
///   values = values of the arm + T u.
/// Against a MODEL u is whitened by its covariance, so that its prior is |u|^2 / 2.
struct Base {
  MatrixXd T;               ///< (parameters x directions)
  std::vector<MatrixXd> X;  ///< (rows x directions) of every joint
  VectorXd ridge;           ///< of every direction
  bool prior = false;
  Eigen::Index hidden = 0;  ///< number of the last directions, which have a torque only under another gravity than the MODEL's
  /// Levels that cannot be negative: value + row . u >= 0. Empty for a MODEL, whose prior bounds them.
  MatrixXd nonnegative;
  VectorXd value;
};

/// The columns of the directions T at other rows of the same arm.
MatrixXd base_columns(const Rows& rows, int joint, const MatrixXd& T);

/// The base of an arm whose values are fitted, with at most `most` directions: errors of the signals make dependent columns look
/// independent.
Base fitted_base(const Rows& rows, Eigen::Index most);

/// Covariance of values from their scatter F over clusters of rows (values x clusters) and the Gram matrix G of their columns:
///   F F' + (G / noise + D^-1)^-1
/// A few clusters scatter in a few directions only. In all others the values are as uncertain as noise makes them, which is the
/// same in every direction of torque; D bounds what the torques do not determine by a part of each value's own variance.
MatrixXd covariance_of(const MatrixXd& F, const MatrixXd& G);

/// The base of a MODEL at rows of its own arm: parameters vary by their covariance, friction and offsets as
/// from day to day, and undetermined parameters freely.
Base prior_base(const Rows& rows, const Model& model);

}  // namespace veridyn::search
