#pragma once

#include "calibration/links/link_chain.hpp"
#include "veridyn/calibration/capture.hpp"

namespace veridyn::internal {

struct LinkNoise {
  double position = 1e-3;  ///< [m] standard deviation of one coordinate
  double angle = 1e-2;     ///< [rad] standard deviation about one axis
};

/// Poses of a fit, with their weights.
struct LinkData {
  const PoseCapture* poses = nullptr;
  std::vector<int> rows;
  std::vector<char> is_outlier;  ///< one flag per frame of the capture
  LinkNoise noise;
};

struct LinkErrors {
  std::vector<double> position, angle;  ///< [m], [rad] by row of the data
};

/// J' W J and J' W r over all parameters, without outliers.
struct LinkNormal {
  MatrixXd N;
  VectorXd g;
  double chi2 = 0.0;
  int residuals = 0;
};

/// Fits the active parameters starting from x; noise and outliers are fixed.
VectorXd fitted_links(LinkChain& chain, const LinkData& data, const std::vector<int>& active,
                      const VectorRef& x, double huber);

/// The same with the noise estimated iteratively and outliers marked in the data.
VectorXd robustly_fitted_links(LinkChain& chain, LinkData& data, const std::vector<int>& active,
                               const VectorRef& x, double outlier);

LinkErrors link_errors(LinkChain& chain, const LinkData& data, const VectorRef& x);

LinkNormal link_normal(LinkChain& chain, const LinkData& data, const VectorRef& x);

/// Root mean square of the errors, with or without outliers.
double rms_of(const std::vector<double>& errors, const LinkData& data, bool with_outliers);

/// Poses of base and tool for which the unmodified robot is closest to the measured poses: A X = Y B, or the
/// linear problem of positions alone. Fixed poses stay the identity.
void start_poses(const Model& arm, int frame, const PoseCapture& poses, bool base_free,
                 bool tool_free, Eigen::Isometry3d& base, Eigen::Isometry3d& tool);

}  // namespace veridyn::internal
