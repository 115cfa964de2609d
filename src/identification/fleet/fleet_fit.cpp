#include "identification/fleet/fleet_fit.hpp"

#include <algorithm>
#include <cmath>

#include "identification/base_solution.hpp"
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

std::pair<double, double> median_and_spread(const std::vector<double>& all) {
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
  const std::vector<std::string> names = parameter_names(parameters_);
  std::vector<UndeterminedArm> out;
  const auto undetermined = [&](const FittedArm& one) {
    VectorXd torque2(joints_);
    for (Eigen::Index i = 0; i < joints_; ++i) torque2[i] = one.data.joints[i].rhs_norm2();
    const SquareRootInformation total = weighted_total(one.data.joints, torque2.cwiseMax(1e-300).cwiseSqrt().cwiseInverse(), names);
    const std::string why = torque2.isZero(0.0) ? "its torques are zero throughout"
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

std::vector<SquareRootInformation> FleetFit::with_gains(const ArmFactor& arm, const VectorXd& at) const {
  std::vector<SquareRootInformation> out;
  for (Eigen::Index i = 0; i < joints_; ++i) {
    const SquareRootInformation& f = arm.joints[i];
    MatrixXd T = MatrixXd::Identity(f.size(), f.size() + 1);
    if (at.size() > 0) T.rightCols(1) = joint_coefficients(f, at);
    std::vector<std::string> columns = f.columns();
    columns.push_back(columns_[own_ + i]);
    out.push_back(f.transformed(T, std::move(columns)));
  }
  return out;
}

SquareRootInformation FleetFit::arm_factor(const std::vector<SquareRootInformation>& joints, const VectorXd& weights) const {
  SquareRootInformation out = weighted_total(joints, weights, columns_);
  const VectorXd norms = out.column_norms();
  MatrixXd rows = MatrixXd::Zero(own_ + joints_, out.size());
  for (Eigen::Index k = 0; k < rows.rows(); ++k)
    rows(k, k) = norms[k] > 0.0 ? (k < own_ ? fleets::numbers.own_ridge : fleets::numbers.gain_ridge) * norms[k] : 1.0;
  out.absorb(rows, VectorXd::Zero(rows.rows()));
  return out;
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

// Squared residual of every joint, unweighted.
VectorXd FleetFit::residual2(const std::vector<SquareRootInformation>& joints, const VectorXd& values) const {
  VectorXd out(joints_);
  for (Eigen::Index i = 0; i < joints_; ++i) out[i] = joints[i].residual2(joint_coefficients(joints[i], values));
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
    each_arm([&](FittedArm& f) {
      f.joints = with_gains(f.data, f.values);
      f.factor = arm_factor(f.joints, weights);
    });
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
  f.values = values(f.factor, beta_);
  f.residual2 = residual2(f.joints, f.values);
  f.alone2 = residual2(f.joints, least_squares(f.factor));
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
  const auto [median, spread] = median_and_spread(all);
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
                            std::min(fleets::numbers.most_freedom, degrees_of_freedom() + more_freedom));
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
