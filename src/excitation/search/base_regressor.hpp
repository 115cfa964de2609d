#pragma once

#include <memory>
#include <vector>

#include "veridyn/math/motion_samples.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

class StackedColumns;

/// Information of a motion about the base parameters of an arm: the Gram matrix W' W of the stacked
/// base regressor (thesis 5.24), bodies and effects.
///
/// The base columns are those of standard parameters that are best conditioned at random states
/// within the limits; among equals effects come first and masses last. They span the same space as
/// the base columns of base_parameters(). Immutable: serves several threads.
class BaseRegressor {
 public:
  /// @param rounding  share of each joint's largest speed within which the sign of a velocity is
  /// smoothed, so that the Gram matrix is differentiable; 0: unmodified columns. The base columns
  /// are the same.
  explicit BaseRegressor(const Model& arm, double rounding = 0.0);

  /// Uses the given base columns, indices among those of the bodies, ten each, and of the effects; empty: the
  /// columns described above. If they span less than all columns, the others are regrouped approximately at
  /// random states.
  BaseRegressor(const Model& arm, const std::vector<int>& base, double rounding = 0.0);

  /// Number of base parameters.
  int size() const { return static_cast<int>(base_.size()); }

  /// W' W, (size x size), of the rows of all joints. Effects with memory start unloaded and follow
  /// the rows in order.
  MatrixXd gram(const MotionSamples& motion) const;

  /// Derivatives of a function of the Gram matrix with respect to q, dq and ddq of every row, (rows x 3 n).
  /// Those of bodies are computed by dual numbers; those of effects, which are functions of a few numbers per
  /// sample, by differences of fourth order; those of effects with memory by an adjoint pass.
  ///
  /// @param by_gram  (size x size), symmetric: derivative of the function with respect to the Gram matrix.
  MatrixXd gradient(const MotionSamples& motion, const MatrixXd& by_gram) const;

  /// The norm of every base column over the random states: a scaling that does not depend on the
  /// motion.
  const VectorXd& scale() const { return scale_; }

  /// T (size x size, upper triangle): the columns of W T are orthonormal, per state, over the
  /// random states.
  const MatrixXd& orthogonal_basis() const { return orthogonal_; }

  /// W, (rows n x size), the rows of joint 1 first.
  MatrixXd stacked(const MotionSamples& motion) const;

  /// Indices of the leading standard parameters, among those of the bodies, ten each, and of the effects.
  const std::vector<int>& base() const { return base_; }

  /// K, (size x standard parameters): the base parameters are K times the standard ones.
  const MatrixXd& combination() const { return combination_; }

  /// The columns of the Gram matrix, for criteria with other weights.
  const std::shared_ptr<const StackedColumns>& columns() const { return columns_; }

 private:
  std::shared_ptr<const StackedColumns> columns_;
  VectorXd ones_;
  std::vector<int> base_;  // base columns in the order of preference
  VectorXd scale_;
  MatrixXd orthogonal_;
  MatrixXd combination_;
};

/// Condition number of the base regressor with its columns scaled to norm one (thesis 5.26, 5.27),
/// from its Gram matrix; infinite above about 1e7, the resolution of this method.
double scaled_condition_number(const MatrixXd& gram);

/// Condition number of the base regressor with unscaled columns.
double plain_condition_number(const MatrixXd& gram);

/// ln det of the Gram matrix after dividing its columns by `scale`: minus twice the logarithm of the
/// confidence ellipsoid's volume, up to a constant. Minus infinity if a parameter is not identifiable.
double log_determinant(const MatrixXd& gram, const VectorXd& scale);

}  // namespace veridyn
