#pragma once

#include <string>

#include "closed_forms.hpp"
#include "veridyn/calibration/hand_eye.hpp"

namespace veridyn::internal {

/// One form of the relation A_k X = Y B_k, fitted.
struct PairFit {
  std::string reason;  ///< reason for a missing fit; empty: fitted
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d Y = Eigen::Isometry3d::Identity();
  MatrixXd covariance_X, covariance_Y;  ///< (6 x 6): rotation vector in its own frame, translation
  double degrees_of_freedom = 1.0;
  double noise = 0.0, noise_angle = 0.0;  ///< [m], [rad] robust deviations of one component
  std::vector<Eigen::Vector3d> residuals;
  std::vector<double> angles;
  std::vector<char> is_outlier;
};

/// Fits one form robustly, or gives the reason why these poses do not determine it.
/// @param smallest_swing  [deg] smallest rms turn about a second axis.
PairFit fit_pairs(const Isometries& A, const Isometries& B, HandEyeForm form,
                  double smallest_swing);

}  // namespace veridyn::internal
