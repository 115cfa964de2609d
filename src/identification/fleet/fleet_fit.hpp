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
std::pair<double, double> median_and_spread(const std::vector<double>& all);

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
  std::vector<SquareRootInformation> joints = {};  ///< factors of the same rows, each with a column for the gain of
                                                   ///< its torque
  SquareRootInformation factor = {};
  VectorXd values = {};              ///< values of all columns; gains as shares
  VectorXd uncertain = {};           ///< standard deviation of each own value for white noise
  VectorXd independent = {};         ///< share of each own column outside the span of the others
  VectorXd residual2 = {}, alone2 = {};  ///< squared residual of each joint, with the fleet's bodies and with its own
  bool odd = false;                  ///< true: its bodies differ from those of the fleet
  double excess = 0.0;               ///< distance of its bodies from the fleet's: ln of the ratio by which its own bodies reduce the squares
  double deviations = 0.0;           ///< distance of `excess` from the fleet's median, in robust deviations
};

/// Fits the block-arrow problem of a fleet: alternates between the values that all arms share and each arm's
/// own values. Arms with different bodies do not contribute to the shared values.
class FleetFit {
 public:
  FleetFit(const Model& arm, std::vector<ArmFactor> arms, const FleetOptions& options);

  /// Removes and returns the arms whose recordings do not determine their bodies: with bodies of its own such
  /// an arm would explain everything, and always seem to differ.
  std::vector<UndeterminedArm> extract_undetermined();

  void solve();

  const BaseParameters& base() const { return base_; }
  const std::vector<StandardParameter>& parameters() const { return parameters_; }
  /// Own parameters, gains of joints, shared parameters: the columns of arm_factor().
  const std::vector<std::string>& columns() const { return columns_; }
  Eigen::Index own() const { return own_; }        ///< number of own parameters
  Eigen::Index shared() const { return shared_; }  ///< number of shared ones
  const StandardParameter& own_parameter(int k) const { return parameters_[own_parameters_[k]]; }
  const std::vector<FittedArm>& arms() const { return arms_; }
  const VectorXd& beta() const { return beta_; }  ///< shared values

  /// Rows of each joint with a further column for the gain of its torque: the torque for the values `at`.
  std::vector<SquareRootInformation> with_gains(const ArmFactor& arm, const VectorXd& at) const;
  /// A factor of these rows over columns(), with joint weights.
  SquareRootInformation arm_factor(const std::vector<SquareRootInformation>& joints, const VectorXd& weights) const;
  /// Information of this factor about the shared columns, with the arm's own columns eliminated.
  SquareRootInformation shared_information(const SquareRootInformation& factor) const;
  /// All values of an arm from its factor, for given shared values.
  VectorXd values(const SquareRootInformation& factor, const VectorXd& beta) const;

  /// Standard deviations of beta(), by leaving out one group of arms at a time.
  VectorXd deviations() const;
  /// Degrees of freedom of a robust deviation over the arms.
  double degrees_of_freedom() const { return fleets::kEfficiency * (static_cast<double>(arms_.size()) - 1.0); }
  /// Number of tested quantities: every own value and the bodies of every arm.
  double tested() const;
  /// Number of deviations beyond which one of `tested` quantities is an outlier.
  double threshold(double tested, double more_freedom = 0.0) const;
  /// Median of FittedArm::excess in the last search for outliers.
  double median_excess() const { return median_excess_; }

 private:
  VectorXd joint_coefficients(const SquareRootInformation& factor, const VectorXd& values) const;
  VectorXd residual2(const std::vector<SquareRootInformation>& joints, const VectorXd& values) const;
  template <typename Squares>
  VectorXd weights_from(const Squares& squares) const;
  void fit(FittedArm& arm) const;
  void mark_outliers();

  std::vector<FittedArm> arms_;
  FleetOptions options_;
  std::vector<StandardParameter> parameters_;
  BaseParameters base_;
  Eigen::Index joints_, own_ = 0, shared_ = 0;
  std::vector<int> own_parameters_;  // indices in parameters_
  std::vector<std::string> columns_;
  std::unordered_map<std::string, Eigen::Index> place_;  // indices in columns_, by name
  VectorXd beta_;
  double median_excess_ = 0.0;
};

/// Adds the spread of every own value and gain over the fleet, and the arms that are far from its median.
void add_spreads(const Model& arm, const FleetFit& fit, Fleet& fleet);

}  // namespace veridyn
