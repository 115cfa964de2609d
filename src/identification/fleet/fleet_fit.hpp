#pragma once

#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "identification/fleet/fleet_numbers.hpp"
#include "veridyn/identification/base_parameters.hpp"
#include "veridyn/identification/fleet.hpp"

namespace veridyn {

/// Median and robust standard deviation of the finite values.
std::pair<double, double> centre_of(const std::vector<double>& all);

/// Data of one arm: a factor per joint over all its recordings.
struct ArmFactor {
  std::string name;
  int recordings = 0;
  double rows = 0.0;
  std::vector<SquareRootInformation> joints;
  std::vector<std::string> still;  ///< coordinates that never move
};

/// One arm with its data, its factor over columns(), its values and its residuals.
struct FittedArm {
  ArmFactor data;
  SquareRootInformation factor = {};
  VectorXd values = {};              ///< of all columns; gains as shares
  VectorXd uncertain = {};           ///< standard deviation of each own value for white noise
  VectorXd independent = {};         ///< share of each own column outside the span of the others
  VectorXd residual2 = {}, alone2 = {};  ///< per joint, with the fleet's bodies and with its own
  bool odd = false;                  ///< its bodies differ from the fleet's
  double excess = 0.0;               ///< robust distance of its bodies from the fleet's: ln of the squares that its own explain
  double deviations = 0.0;           ///< of it, from the fleet's median
};

/// Fits the block arrow of a fleet: the values that all arms share and every arm's own in turn. Arms with other bodies
/// are left out of the shared values.
class FleetFit {
 public:
  FleetFit(const Model& arm, std::vector<ArmFactor> arms, const FleetOptions& options);

  /// Removes the arms whose own recordings do not determine their bodies: bodies of its own would explain everything on
  /// such an arm, so that it would always seem to differ.
  std::vector<UndeterminedArm> extract_undetermined();

  void solve();

  const BaseParameters& base() const { return base_; }
  const std::vector<StandardParameter>& parameters() const { return parameters_; }
  /// Own parameters, gains of joints, shared parameters: the columns of of_arm().
  const std::vector<std::string>& columns() const { return columns_; }
  Eigen::Index own() const { return own_; }        ///< number of own parameters
  Eigen::Index shared() const { return shared_; }  ///< number of shared ones
  const StandardParameter& own_parameter(int k) const { return parameters_[own_parameters_[k]]; }
  const std::vector<FittedArm>& arms() const { return arms_; }
  const VectorXd& beta() const { return beta_; }  ///< shared values

  /// One arm's rows over columns(), with joint weights; the gains' columns are the torque for the values `at`, absent
  /// where these are empty.
  SquareRootInformation of_arm(const ArmFactor& arm, const VectorXd& weights, const VectorXd& at) const;
  /// The information of such a factor about the shared columns after eliminating its own.
  SquareRootInformation shared_information(const SquareRootInformation& factor) const;
  /// All values of an arm, for given shared ones, from its factor.
  VectorXd values(const SquareRootInformation& factor, const VectorXd& beta) const;

  /// Standard deviations of beta() by leaving out one group of arms at a time.
  VectorXd deviations() const;
  /// Degrees of freedom of a robust deviation over the arms.
  double freedom() const { return fleets::kEfficiency * (static_cast<double>(arms_.size()) - 1.0); }
  /// Number of tested quantities: every own value and the bodies of every arm.
  double tested() const;
  /// Deviations beyond which one of so many quantities is an outlier.
  double threshold(double tested, double more_freedom = 0.0) const;
  /// Median of FittedArm::excess when outliers were looked for last.
  double median_excess() const { return median_excess_; }

 private:
  VectorXd joint_coefficients(const SquareRootInformation& factor, const VectorXd& values) const;
  VectorXd residual2(const ArmFactor& arm, const VectorXd& values, const VectorXd& at) const;
  template <typename Squares>
  VectorXd weights_from(const Squares& squares) const;
  void fit(FittedArm& arm) const;
  void mark_outliers();

  std::vector<FittedArm> arms_;
  FleetOptions options_;
  std::vector<StandardParameter> parameters_;
  BaseParameters base_;
  Eigen::Index joints_, own_ = 0, shared_ = 0;
  std::vector<int> own_parameters_;  // in parameters_
  std::vector<std::string> columns_;
  std::unordered_map<std::string, Eigen::Index> place_;  // in columns_
  VectorXd beta_;
  double median_excess_ = 0.0;
};

/// How every own value and gain spreads over the arms of the fleet, and the arms that are far off.
void add_spreads(const Model& arm, const FleetFit& fit, Fleet& fleet);

}  // namespace veridyn
