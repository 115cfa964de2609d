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
  double value = 0.0;                         ///< Value by the model's parameters
  /// Least squares without any condition: what the scatter belongs to. A physically possible model
  /// lies beside it where the data ask for the impossible.
  double free = 0.0;
  /// This parameter's row of F, where F F' is the covariance of all `free` (jackknife over
  /// clusters: phases of the motion or stretches of time, never single samples). One column per
  /// cluster, as far as those are at most kClustersKept; empty if there were fewer than three.
  VectorXd scatter;
};

/// Beyond this number the columns of F are no longer clusters, only some factor of the covariance.
constexpr int kClustersKept = 128;

/// What an identification leaves in its MODEL file for later statistics: its base parameters with
/// their covariance.
struct IdentifiedBase {
  std::vector<std::string> recordings;  ///< names of the files that it learned from
  int clusters = 0;                     ///< Clusters of the jackknife; its degrees of freedom are one fewer
  VectorXd error;  ///< (n) relative error on the recordings that it learned from
  VectorXd noise;  ///< (n) [N m] or [N] white noise, one sample in 0.1 s, as uncertain as what it left; or empty
  /// (clusters x n) how the information is spread over the clusters, by joint: it is alike where
  /// the same motion was recorded again, and its clusters are then pairs. Empty where not known.
  MatrixXd motion;
  std::vector<IdentifiedParameter> parameters;

  bool has_scatter() const { return clusters > 2 && !parameters.empty(); }
};

}  // namespace veridyn
