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

/// N = J' W J and g = J' W r over all parameters, chi2 = r' W r and the size of r, without outliers.
struct LinkNormal {
  MatrixXd N;
  VectorXd g;
  double chi2 = 0.0;
  int residuals = 0;
};

/// All parameters after a fit of the active ones (indices) from x, with the noise and outliers of `data`.
/// @param huber  standard deviations beyond which a residual counts linearly; 0: squares.
VectorXd fitted_links(LinkChain& chain, const LinkData& data, const std::vector<int>& active,
                      const VectorRef& x, double huber);

/// Like fitted_links(), but estimates the noise and marks poses beyond `outlier` deviations, both in `data`.
VectorXd robustly_fitted_links(LinkChain& chain, LinkData& data, const std::vector<int>& active,
                               const VectorRef& x, double outlier);

/// Magnitudes of the errors of position and orientation of every row, with the parameters x.
LinkErrors link_errors(LinkChain& chain, const LinkData& data, const VectorRef& x);

/// Normal equations at the parameters x.
LinkNormal link_normal(LinkChain& chain, const LinkData& data, const VectorRef& x);

/// Root mean square of one error per row of the data, with or without outliers; 0 if none remains.
double rms_of(const std::vector<double>& errors, const LinkData& data, bool with_outliers);

/// Sets `base` and `tool` so that the unmodified robot is closest to the measured poses: by A X = Y B, or the
/// linear problem of positions alone. A pose that is not free is set to the identity.
void estimate_attached_poses(const Model& arm, FrameIndex frame, const PoseCapture& poses, bool base_free,
                 bool tool_free, Eigen::Isometry3d& base, Eigen::Isometry3d& tool);

}  // namespace veridyn::internal
