#pragma once

#include <vector>

#include "veridyn/dynamics/regressor_batch.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/kinematics/motion_samples.hpp"

namespace veridyn {

/// What a motion says about the base parameters of an arm: the Gram matrix W' W of the stacked base
/// regressor (thesis 5.24), bodies and effects.
///
/// Base columns are the first independent ones in the order: effects, then first moments and
/// inertias, then masses; independence is numerical, at random states within the limits. Immutable:
/// serves several threads.
class BaseRegressor {
 public:
  explicit BaseRegressor(const Model& arm);

  /// Number of base parameters.
  int size() const { return static_cast<int>(base_.size()); }

  /// W' W, (size x size), of the rows of all joints. Effects with memory start fresh and follow the
  /// rows in order.
  MatrixXd gram(const MotionSamples& motion) const;

  /// The norm of every base column over the random states; a scale that does not depend on the
  /// motion.
  const VectorXd& scale() const { return scale_; }

 private:
  std::vector<MatrixXd> columns_by_joint(const MotionSamples& motion) const;
  MatrixXd stacked(const MotionSamples& motion) const;

  Model arm_;
  RegressorBatch bodies_;
  std::vector<BoundEffect> effects_;
  int column_count_ = 0;
  std::vector<std::vector<int>> of_joint_;  // columns of every joint's rows, bodies first
  std::vector<int> base_;                   // base columns, in the order of preference
  std::vector<int> place_;                  // of a column among the base columns, or -1
  VectorXd scale_;
};

/// Condition number of the base regressor with its columns scaled to norm one (thesis 5.26, 5.27),
/// from its Gram matrix; infinite above about 1e7, where that cannot tell.
double scaled_condition_number(const MatrixXd& gram);

/// ln det of the Gram matrix after dividing its columns by `scale`: twice the logarithm of what is
/// left of the confidence ellipsoid's volume is its negative. Minus infinity where the motion
/// leaves a parameter open.
double log_determinant(const MatrixXd& gram, const VectorXd& scale);

}  // namespace veridyn
