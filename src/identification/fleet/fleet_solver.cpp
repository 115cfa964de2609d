#include "identification/fleet/fleet_solver.hpp"

#include <algorithm>
#include <cmath>

#include "identification/estimation/least_squares.hpp"
#include "math/clustered_statistics.hpp"
#include "math/median.hpp"
#include "math/numbers.hpp"
#include "math/parallel.hpp"
#include "math/student_t.hpp"

namespace veridyn {
namespace {

double median_of(std::vector<double> v) {
  return v.empty() ? kNaN : median(std::move(v));
}

}  // namespace

std::pair<double, double> centre_of(const std::vector<double>& all) {
  std::vector<double> finite;
  for (const double x : all)
    if (std::isfinite(x)) finite.push_back(x);
  const double centre = median_of(finite);
  for (double& x : finite) x = std::abs(x - centre);
  return {centre, kMadToDeviation * median_of(finite)};
}

template <typename Do>
void FleetSolver::each_arm(const Do& act) {
  parallel_for(static_cast<int>(arms_.size()), options_.threads,
               [&](int a) { act(static_cast<size_t>(a)); });
}

template <typename Squares>
VectorXd FleetSolver::weights_from(const Squares& squares) const {
  VectorXd out(problem_.joints());
  for (int i = 0; i < problem_.joints(); ++i) {
    std::vector<double> all;
    for (size_t a = 0; a < arms_.size(); ++a) all.push_back(squares(a, i) / std::max(1.0, arms_[a].joints[i].rows()));
    out[i] = 1.0 / std::max(1e-300, std::sqrt(median_of(std::move(all))));
  }
  return out;
}

void FleetSolver::solve() {
  VectorXd weights = weights_from([&](size_t a, int i) { return arms_[a].joints[i].rhs_norm2(); });
  for (int round = 0; round < fleets::numbers.rounds; ++round) {
    const VectorXd at_beta = beta_;
    each_arm([&](size_t a) {
      fitted_[a].factor = problem_.arm_information(a, weights, at_beta, fitted_[a].eta);
    });
    SquareRootInformation total(problem_.shared());
    for (const FittedArm& f : fitted_)
      if (!f.odd) total.merge(problem_.shared_information(f.factor));
    beta_ = least_squares(total);
    each_arm([&](size_t a) { fit_arm(a, at_beta); });
    weights = weights_from([&](size_t a, int i) { return fitted_[a].residual2[i]; });
    // Outliers found in the last round were excluded from the last fit.
    if (round + 1 < fleets::numbers.rounds) mark_outliers();
  }
}

void FleetSolver::fit_arm(size_t a, const VectorXd& at_beta) {
  FittedArm& f = fitted_[a];
  const VectorXd at_eta = f.eta;
  f.eta = problem_.own_values(f.factor, beta_);
  f.residual2 = problem_.residual2(a, beta_, f.eta, at_beta, at_eta);
  const VectorXd alone = least_squares(f.factor);
  const Eigen::Index own = alone.size() - beta_.size();
  const VectorXd bodies = alone.tail(beta_.size());
  f.alone2 = problem_.residual2(a, bodies, alone.head(own), at_beta, at_eta);
  f.uncertain = f.factor.R()
                    .topLeftCorner(own, own)
                    .triangularView<Eigen::Upper>()
                    .solve(MatrixXd::Identity(own, own))
                    .rowwise()
                    .norm();
  // The part of own columns outside the span of those before them: the diagonal of R. Own columns
  // are few.
  const VectorXd norms = f.factor.column_norms();
  f.telling = f.factor.R().diagonal().head(own).cwiseAbs().cwiseQuotient(
      norms.head(own).cwiseMax(1e-300));
}

std::vector<double> FleetSolver::relative_excess() const {
  std::vector<double> out;
  for (const FittedArm& f : fitted_) {
    const Eigen::ArrayXd ratio = f.residual2.array() / f.alone2.array().max(1e-300);
    out.push_back(std::log(std::max(ratio.maxCoeff(), 1.0)));
  }
  return out;
}

void FleetSolver::mark_outliers() {
  const std::vector<double> all = relative_excess();
  const auto [median, spread] = centre_of(all);
  const double far = threshold(static_cast<double>(arms_.size()));
  median_excess_ = median;
  size_t count = 0;
  for (size_t a = 0; a < arms_.size(); ++a) {
    fitted_[a].excess = all[a];
    fitted_[a].deviations = (all[a] - median) / std::max(spread, fleets::kLeastSpread);
    fitted_[a].odd = all[a] > fleets::numbers.least_excess && fitted_[a].deviations > far;
    count += static_cast<size_t>(fitted_[a].odd);
  }
  if (2 * count < arms_.size()) return;
  for (FittedArm& f : fitted_) f.odd = false;  // half of a fleet cannot be outliers
}

double FleetSolver::tested_quantities() const {
  return static_cast<double>(arms_.size()) *
         (static_cast<double>(problem_.own().size()) + problem_.joints() + 1.0);
}

double FleetSolver::threshold(double looked_at, double more_freedom) const {
  return student_t_quantile(options_.significance / std::max(1.0, looked_at),
                            std::min(fleets::numbers.most_freedom, freedom() + more_freedom));
}

VectorXd FleetSolver::deviations() const {
  const size_t groups = std::min(static_cast<size_t>(fleets::numbers.groups), arms_.size());
  std::vector<SquareRootInformation> of_group(groups, SquareRootInformation(problem_.shared()));
  for (size_t a = 0; a < arms_.size(); ++a)
    if (!fitted_[a].odd) of_group[a % groups].merge(problem_.shared_information(fitted_[a].factor));
  return jackknife_deviations(solutions_without(of_group));
}

}  // namespace veridyn
