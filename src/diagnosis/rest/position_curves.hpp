#pragma once

#include <vector>

#include "veridyn/diagnosis/thresholds.hpp"
#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// Smooth functions of the positions, alone and in pairs, fitted to the residual torques of an arm at rest in training
/// poses: ridge regression with the kernel
///
///   k(q, p) = sum_i k_i + sum_(i<j) k_i k_j,   k_i = exp(-(q_i - p_i)^2 / (2 width_i^2))
///
/// over joints that move. Source: Wahba, Spline Models for Observational Data, 1990, chapter 10.
class PositionCurves {
 public:
  PositionCurves(const Identification& at_rest, const Thresholds& limits);

  /// Share of the mean square that the curves predict on held-out poses; 0 unless they predict some of it in
  /// every fold.
  double predicted_share(int joint) const;

 private:
  struct Pose {
    const PredictionSeries* of;
    std::size_t at, fold;
  };

  std::vector<Pose> poses_;                // in the order of their folds
  std::vector<Eigen::Index> fold_begin_;   // first pose of every fold, then the number of poses
  MatrixXd vectors_;
  VectorXd values_;                        // values of the kernel's matrix, which has a diagonal of one
};

}  // namespace veridyn
