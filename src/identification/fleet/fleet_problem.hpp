#pragma once

#include <string>
#include <vector>

#include "veridyn/identification/base_parameters.hpp"
#include "identification/fleet/fleet_numbers.hpp"

namespace veridyn {

/// Data of one arm: a factor per joint over all its recordings.
struct ArmFactor {
  std::string name;
  int recordings = 0;
  double rows = 0.0;
  std::vector<SquareRootInformation> joints;
  std::vector<std::string> still;  ///< coordinates that never move
};

/// The block arrow of a fleet: columns that all arms share, and own columns of each.
class FleetProblem {
 public:
  FleetProblem(const Model& arm, const std::vector<ArmFactor>& arms);

  const std::vector<std::string>& shared() const { return shared_; }
  const std::vector<std::string>& own() const { return own_; }
  const BaseParameters& base() const { return base_; }
  const std::vector<StandardParameter>& parameters() const { return parameters_; }

  /// One arm's rows over (own, gains, shared), with joint weights; the gains' columns are the
  /// torque for `beta` and `eta`, absent where these are empty.
  SquareRootInformation arm_information(size_t arm, const VectorXd& weights, const VectorXd& beta,
                               const VectorXd& eta) const;

  /// Reason why an arm's recordings do not determine its base parameters; empty if they do.
  std::string shortfall_of(const ArmFactor& arm) const;

  /// Information of an arm's factor about the shared columns after eliminating its own.
  SquareRootInformation shared_information(const SquareRootInformation& of_arm) const;

  /// An arm's own values for given shared ones, from its factor: (own + joints).
  VectorXd own_values(const SquareRootInformation& of_arm, const VectorXd& beta) const;

  /// Squared residual of every joint, unweighted, for shared values `beta` and own ones `eta`; gains
  /// multiply the torque of (at_beta, at_eta).
  VectorXd residual2(size_t arm, const VectorXd& beta, const VectorXd& eta, const VectorXd& at_beta,
                     const VectorXd& at_eta) const;

  int joints() const { return joints_; }

 private:
  /// Over a joint's columns: the values of its parameters.
  VectorXd joint_coefficients(const SquareRootInformation& factor, const VectorXd& beta,
                    const VectorXd& eta) const;

  const std::vector<ArmFactor>& arms_;
  std::vector<StandardParameter> parameters_;
  BaseParameters base_;
  std::vector<std::string> shared_, own_;
  int joints_;
};

}  // namespace veridyn
