#pragma once

#include <utility>
#include <vector>

#include "identification/fleet/fleet_numbers.hpp"
#include "identification/fleet/fleet_problem.hpp"
#include "veridyn/identification/fleet.hpp"

namespace veridyn {

/// Median and robust standard deviation of the finite values.
std::pair<double, double> centre_of(const std::vector<double>& all);

/// One arm with its factor, its own values and its residuals.
struct FittedArm {
  SquareRootInformation factor;
  VectorXd eta;                ///< own parameters, then gains as shares
  VectorXd uncertain;          ///< standard deviation of each own value for white noise
  VectorXd telling;            ///< share of each own column outside the span of the others
  VectorXd residual2, alone2;  ///< per joint, with the fleet's bodies and with its own
  bool odd = false;            ///< its bodies differ from the fleet's
  double excess = 0.0;         ///< robust distance of its bodies from the fleet's: ln of the squares that its own explain
  double deviations = 0.0;     ///< of it, from the fleet's median
};

/// Fits the shared values and every arm's own in turn, and leaves out the arms whose bodies are others.
class FleetSolver {
 public:
  FleetSolver(const Model& arm, const std::vector<ArmFactor>& arms, const FleetOptions& options)
      : problem_(arm, arms), arms_(arms), options_(options), fitted_(arms.size()) {}

  void solve();

  const FleetProblem& problem() const { return problem_; }
  const VectorXd& beta() const { return beta_; }
  const FittedArm& fitted(size_t a) const { return fitted_[a]; }

  /// Standard deviations of beta() by leaving out one group of arms at a time.
  VectorXd deviations() const;

  /// Degrees of freedom of a robust deviation over the arms.
  double freedom() const { return fleets::kEfficiency * (static_cast<double>(arms_.size()) - 1.0); }

  /// Number of tested quantities: every own value and the bodies of every arm.
  double tested_quantities() const;

  /// Deviations beyond which one of so many quantities is an outlier.
  double threshold(double looked_at, double more_freedom = 0.0) const;

  /// Median of FittedArm::excess when outliers were looked for last.
  double median_excess() const { return median_excess_; }

 private:
  template <typename Do>
  void each_arm(const Do& act);

  /// Per joint: one over the root of the median over the arms of squares(arm, joint) per row.
  template <typename Squares>
  VectorXd weights_from(const Squares& squares) const;

  void fit_arm(size_t a, const VectorXd& at_beta);
  std::vector<double> relative_excess() const;
  void mark_outliers();

  FleetProblem problem_;
  const std::vector<ArmFactor>& arms_;
  const FleetOptions& options_;
  std::vector<FittedArm> fitted_;
  VectorXd beta_;
  double median_excess_ = 0.0;
};

}  // namespace veridyn
