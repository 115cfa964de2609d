#include "identification/fleet/fleet_fit.hpp"

#include <algorithm>
#include <cmath>

#include "identification/estimation/least_squares.hpp"
#include "identification/shortfall.hpp"
#include "math/clustered_statistics.hpp"
#include "math/median.hpp"
#include "math/numbers.hpp"
#include "math/parallel.hpp"
#include "math/student_t.hpp"

namespace veridyn {
namespace {

double median_of(std::vector<double> v) { return v.empty() ? kNaN : median(std::move(v)); }

}  // namespace

std::pair<double, double> centre_of(const std::vector<double>& all) {
  std::vector<double> finite;
  for (const double x : all)
    if (std::isfinite(x)) finite.push_back(x);
  const double centre = median_of(finite);
  for (double& x : finite) x = std::abs(x - centre);
  return {centre, kMadToDeviation * median_of(finite)};
}

FleetFit::FleetFit(const Model& arm, std::vector<ArmFactor> arms, const FleetOptions& options)
    : options_(options),
      parameters_(standard_parameters(arm)),
      base_(base_parameters(identifiable_factor(arm, 1), preferred_columns(parameters_))),
      joints_(arm.joints()) {
  for (ArmFactor& one : arms) arms_.push_back({std::move(one)});
  std::vector<std::string> shared;
  for (const int j : base_.independent) {
    (parameters_[j].effect ? columns_ : shared).push_back(parameters_[j].name);
    if (parameters_[j].effect) own_parameters_.push_back(j);
  }
  own_ = static_cast<Eigen::Index>(columns_.size());
  shared_ = static_cast<Eigen::Index>(shared.size());
  for (Eigen::Index i = 0; i < joints_; ++i) columns_.push_back("gain " + std::to_string(i));
  columns_.insert(columns_.end(), shared.begin(), shared.end());
  for (size_t k = 0; k < columns_.size(); ++k) place_.emplace(columns_[k], static_cast<Eigen::Index>(k));
}

std::vector<UndeterminedArm> FleetFit::extract_undetermined() {
  std::vector<std::string> names;
  for (const StandardParameter& p : parameters_) names.push_back(p.name);
  std::vector<UndeterminedArm> out;
  const auto undetermined = [&](const FittedArm& one) {
    SquareRootInformation total(names);
    double torque2 = 0.0;
    for (const SquareRootInformation& f : one.data.joints) {
      torque2 += f.rhs_norm2();
      total.merge(f, 1.0 / std::sqrt(std::max(1e-300, f.rhs_norm2())));
    }
    const std::string why = torque2 == 0.0 ? "its torques are zero throughout"
                                           : shortfall(base_, base_parameters(total, preferred_columns(parameters_)), one.data.still);
    if (!why.empty()) out.push_back({one.data.name, why});
    return !why.empty();
  };
  std::vector<FittedArm> rest;
  for (FittedArm& one : arms_)
    if (!undetermined(one)) rest.push_back(std::move(one));
  arms_ = std::move(rest);
  return out;
}

// The values that correspond to the columns of a joint's factor.
VectorXd FleetFit::joint_coefficients(const SquareRootInformation& factor, const VectorXd& values) const {
  VectorXd x = VectorXd::Zero(factor.size());
  for (int c = 0; c < factor.size(); ++c) {
    const auto found = place_.find(factor.columns()[c]);
    if (found != place_.end()) x[c] = values[found->second];
  }
  return x;
}

SquareRootInformation FleetFit::of_arm(const ArmFactor& arm, const VectorXd& weights, const VectorXd& at) const {
  SquareRootInformation out(columns_);
  const auto width = static_cast<Eigen::Index>(columns_.size());
  double rho2 = 0.0, rows = 0.0;
  for (Eigen::Index i = 0; i < joints_; ++i) {
    const SquareRootInformation& f = arm.joints[i];
    const MatrixXd R = f.R();
    MatrixXd A = MatrixXd::Zero(f.size(), width);
    for (int c = 0; c < f.size(); ++c) {
      const auto found = place_.find(f.columns()[c]);
      if (found != place_.end()) A.col(found->second) = weights[i] * R.col(c);
    }
    if (at.size() > 0) A.col(own_ + i) = weights[i] * (R * joint_coefficients(f, at));
    out.absorb(A, weights[i] * f.z());
    rho2 += weights[i] * weights[i] * f.rho2();
    rows += f.rows();
  }
  const VectorXd norms = out.column_norms();
  MatrixXd ridge = MatrixXd::Zero(own_ + joints_, width);
  for (Eigen::Index k = 0; k < ridge.rows(); ++k)
    ridge(k, k) = norms[k] > 0.0 ? (k < own_ ? fleets::numbers.own_ridge : fleets::numbers.gain_ridge) * norms[k] : 1.0;
  out.absorb(ridge, VectorXd::Zero(ridge.rows()));
  return SquareRootInformation(columns_, out.R(), out.z(), out.rho2() + rho2, rows);
}

SquareRootInformation FleetFit::shared_information(const SquareRootInformation& factor) const {
  return SquareRootInformation({columns_.end() - shared_, columns_.end()}, factor.R().bottomRightCorner(shared_, shared_),
                               factor.z().tail(shared_), factor.rho2(), factor.rows());
}

VectorXd FleetFit::values(const SquareRootInformation& factor, const VectorXd& beta) const {
  const Eigen::Index own = factor.size() - beta.size();
  const MatrixXd R = factor.R();
  const VectorXd rest = factor.z().head(own) - R.topRightCorner(own, beta.size()) * beta;
  const VectorXd own_values = R.topLeftCorner(own, own).triangularView<Eigen::Upper>().solve(rest);
  VectorXd out(factor.size());
  out << own_values, beta;
  return out;
}

// Squared residual of every joint, unweighted; the columns of gains are the torque for the values `at`.
VectorXd FleetFit::residual2(const ArmFactor& arm, const VectorXd& values, const VectorXd& at) const {
  VectorXd out(joints_);
  for (Eigen::Index i = 0; i < joints_; ++i) {
    VectorXd x = joint_coefficients(arm.joints[i], values);
    if (at.size() > 0) x += values[own_ + i] * joint_coefficients(arm.joints[i], at);
    out[i] = arm.joints[i].residual2(x);
  }
  return out;
}

// For each joint the weight 1 / sqrt(median over the arms of squares(arm, joint) per row).
template <typename Squares>
VectorXd FleetFit::weights_from(const Squares& squares) const {
  VectorXd out(joints_);
  for (Eigen::Index i = 0; i < joints_; ++i) {
    std::vector<double> all;
    for (const FittedArm& one : arms_) all.push_back(squares(one, i) / std::max(1.0, one.data.joints[i].rows()));
    out[i] = 1.0 / std::max(1e-300, std::sqrt(median_of(std::move(all))));
  }
  return out;
}

void FleetFit::solve() {
  const auto each_arm = [this](const auto& act) {
    parallel_for(static_cast<int>(arms_.size()), options_.threads, [&](int a) { act(arms_[static_cast<size_t>(a)]); });
  };
  VectorXd weights = weights_from([](const FittedArm& f, Eigen::Index i) { return f.data.joints[i].rhs_norm2(); });
  for (int round = 0; round < fleets::numbers.rounds; ++round) {
    each_arm([&](FittedArm& f) { f.factor = of_arm(f.data, weights, f.values); });
    SquareRootInformation total({columns_.end() - shared_, columns_.end()});
    for (const FittedArm& f : arms_)
      if (!f.odd) total.merge(shared_information(f.factor));
    beta_ = least_squares(total);
    each_arm([&](FittedArm& f) { fit(f); });
    weights = weights_from([](const FittedArm& f, Eigen::Index i) { return f.residual2[i]; });
    // Outliers found in the last round are excluded from the last fit.
    if (round + 1 < fleets::numbers.rounds) mark_outliers();
  }
}

void FleetFit::fit(FittedArm& f) const {
  const VectorXd at = f.values;
  f.values = values(f.factor, beta_);
  f.residual2 = residual2(f.data, f.values, at);
  f.alone2 = residual2(f.data, least_squares(f.factor), at);
  const Eigen::Index own = own_ + joints_;
  f.uncertain = f.factor.R()
                    .topLeftCorner(own, own)
                    .triangularView<Eigen::Upper>()
                    .solve(MatrixXd::Identity(own, own))
                    .rowwise()
                    .norm();
  // Share of each own column outside the span of the earlier ones, by the diagonal of R; there are few own
  // columns.
  f.independent = f.factor.R().diagonal().head(own).cwiseAbs().cwiseQuotient(f.factor.column_norms().head(own).cwiseMax(1e-300));
}

void FleetFit::mark_outliers() {
  std::vector<double> all;
  for (FittedArm& f : arms_) {
    f.excess = std::log(std::max((f.residual2.array() / f.alone2.array().max(1e-300)).maxCoeff(), 1.0));
    all.push_back(f.excess);
  }
  const auto [median, spread] = centre_of(all);
  const double far = threshold(static_cast<double>(arms_.size()));
  median_excess_ = median;
  size_t count = 0;
  for (FittedArm& f : arms_) {
    f.deviations = (f.excess - median) / std::max(spread, fleets::kLeastSpread);
    f.odd = f.excess > fleets::numbers.least_excess && f.deviations > far;
    count += static_cast<size_t>(f.odd);
  }
  if (2 * count < arms_.size()) return;
  for (FittedArm& f : arms_) f.odd = false;  // half of a fleet cannot consist of outliers
}

double FleetFit::tested() const { return static_cast<double>(arms_.size()) * (static_cast<double>(own_ + joints_) + 1.0); }

double FleetFit::threshold(double tested, double more_freedom) const {
  return student_t_quantile(options_.significance / std::max(1.0, tested),
                            std::min(fleets::numbers.most_freedom, freedom() + more_freedom));
}

VectorXd FleetFit::deviations() const {
  const size_t groups = std::min(static_cast<size_t>(fleets::numbers.groups), arms_.size());
  const SquareRootInformation none({columns_.end() - shared_, columns_.end()});
  std::vector<SquareRootInformation> of_group(groups, none);
  for (size_t a = 0; a < arms_.size(); ++a)
    if (!arms_[a].odd) of_group[a % groups].merge(shared_information(arms_[a].factor));
  return jackknife_deviations(solutions_without(of_group));
}

}  // namespace veridyn
