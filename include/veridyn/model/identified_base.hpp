#pragma once

#include <map>
#include <string>
#include <vector>

#include "veridyn/math/types.hpp"

namespace veridyn {

/// One combination of standard parameters that recordings determine.
struct IdentifiedParameter {
  std::string
      name;  ///< Name of the standard parameter that leads the combination, whose coefficient is 1
  std::string unit;
  std::map<std::string, double> combination;  ///< coefficients by names of standard parameters
  double value = 0.0;                         ///< value that follows from the model's parameters
  /// Estimate of unconstrained least squares, to which the scatter belongs. It differs from `value`
  /// where the unconstrained optimum is not physically consistent.
  double free = 0.0;
  /// This parameter's row of F, where F F' is the covariance of all `free` (jackknife over
  /// clusters: phases of the motion or segments of time, never single samples). One column per
  /// cluster, as far as those are at most kClustersKept; empty if there were fewer than three.
  VectorXd scatter;
};

/// With more clusters than this, F is compressed: its columns are then a factor of the covariance
/// and no longer single clusters.
constexpr int kClustersKept = 128;

/// Statistics that an identification writes into its model file: base parameters with their
/// covariance.
struct IdentifiedBase {
  std::vector<std::string> recordings;  ///< names of the training recordings
  int clusters = 0;                     ///< Clusters of the jackknife; its degrees of freedom are one fewer
  VectorXd error;  ///< (n) relative error on the training recordings
  /// (n) [N m] or [N] standard deviation of white noise, with one independent sample in 0.1 s, that would have
  /// the effect of the residual; may be empty.
  VectorXd noise;
  /// (clusters x n) share of every cluster in the information of each joint. Where one motion was
  /// recorded twice the shares repeat, and its clusters are pairs. Empty where not known.
  MatrixXd motion;
  std::vector<IdentifiedParameter> parameters;

  bool has_scatter() const { return clusters > 2 && !parameters.empty(); }
};

}  // namespace veridyn
