#include "identification/fleet/fleet_problem.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "identification/shortfall.hpp"

namespace veridyn {
FleetProblem::FleetProblem(const Model& arm, const std::vector<ArmFactor>& arms)
    : arms_(arms),
      parameters_(standard_parameters(arm)),
      base_(base_parameters(identifiable_factor(arm, 1), preferred_columns(parameters_))),
      joints_(arm.joints()) {
  for (const int j : base_.independent) {
    const StandardParameter& p = parameters_[j];
    (p.effect ? own_ : shared_).push_back(p.name);
  }
}

std::string FleetProblem::shortfall_of(const ArmFactor& arm) const {
  std::vector<std::string> names;
  for (const StandardParameter& p : parameters_) names.push_back(p.name);
  SquareRootInformation total(names);
  for (const SquareRootInformation& f : arm.joints)
    total.merge(f, 1.0 / std::sqrt(std::max(1e-300, f.rhs_norm2())));
  return shortfall(base_, base_parameters(total, preferred_columns(parameters_)), arm.still);
}

VectorXd FleetProblem::joint_coefficients(const SquareRootInformation& factor, const VectorXd& beta,
                                const VectorXd& eta) const {
  std::unordered_map<std::string, double> value;
  for (size_t k = 0; k < shared_.size(); ++k)
    value.emplace(shared_[k], beta[static_cast<Eigen::Index>(k)]);
  for (size_t k = 0; k < own_.size(); ++k)
    value.emplace(own_[k], eta[static_cast<Eigen::Index>(k)]);
  VectorXd x = VectorXd::Zero(factor.size());
  for (int c = 0; c < factor.size(); ++c) {
    const auto found = value.find(factor.columns()[c]);
    if (found != value.end()) x[c] = found->second;
  }
  return x;
}

SquareRootInformation FleetProblem::arm_information(size_t arm, const VectorXd& weights,
                                           const VectorXd& beta, const VectorXd& eta) const {
  std::vector<std::string> columns = own_;
  for (int i = 0; i < joints_; ++i) columns.push_back("gain " + std::to_string(i));
  columns.insert(columns.end(), shared_.begin(), shared_.end());
  std::unordered_map<std::string, Eigen::Index> place;
  for (size_t k = 0; k < columns.size(); ++k)
    place.emplace(columns[k], static_cast<Eigen::Index>(k));
  SquareRootInformation out(columns);
  const auto width = static_cast<Eigen::Index>(columns.size());
  const auto own = static_cast<Eigen::Index>(own_.size());
  double rho2 = 0.0;
  double rows = 0.0;
  for (int i = 0; i < joints_; ++i) {
    const SquareRootInformation& f = arms_[arm].joints[i];
    const MatrixXd R = f.R();
    MatrixXd A = MatrixXd::Zero(f.size(), width);
    for (int c = 0; c < f.size(); ++c) {
      const auto found = place.find(f.columns()[c]);
      if (found != place.end()) A.col(found->second) = weights[i] * R.col(c);
    }
    if (beta.size() > 0) A.col(own + i) = weights[i] * (R * joint_coefficients(f, beta, eta));
    out.absorb(A, weights[i] * f.z());
    rho2 += weights[i] * weights[i] * f.rho2();
    rows += f.rows();
  }
  const VectorXd norms = out.column_norms();
  MatrixXd ridge = MatrixXd::Zero(own + joints_, width);
  for (Eigen::Index k = 0; k < ridge.rows(); ++k)
    ridge(k, k) = norms[k] > 0.0 ? (k < own ? fleets::numbers.own_ridge : fleets::numbers.gain_ridge) * norms[k] : 1.0;
  out.absorb(ridge, VectorXd::Zero(ridge.rows()));
  return SquareRootInformation(columns, out.R(), out.z(), out.rho2() + rho2, rows);
}

SquareRootInformation FleetProblem::shared_information(const SquareRootInformation& of_arm) const {
  const auto k = static_cast<Eigen::Index>(shared_.size());
  return SquareRootInformation(shared_, of_arm.R().bottomRightCorner(k, k), of_arm.z().tail(k),
                               of_arm.rho2(), of_arm.rows());
}

VectorXd FleetProblem::own_values(const SquareRootInformation& of_arm, const VectorXd& beta) const {
  const Eigen::Index own = of_arm.size() - beta.size();
  const MatrixXd R = of_arm.R();
  const VectorXd rest = of_arm.z().head(own) - R.topRightCorner(own, beta.size()) * beta;
  return R.topLeftCorner(own, own).triangularView<Eigen::Upper>().solve(rest);
}

VectorXd FleetProblem::residual2(size_t arm, const VectorXd& beta, const VectorXd& eta,
                                 const VectorXd& at_beta, const VectorXd& at_eta) const {
  const auto own = static_cast<Eigen::Index>(own_.size());
  VectorXd out(joints_);
  for (int i = 0; i < joints_; ++i) {
    const SquareRootInformation& f = arms_[arm].joints[i];
    VectorXd x = joint_coefficients(f, beta, eta);
    if (at_beta.size() > 0) x += eta[own + i] * joint_coefficients(f, at_beta, at_eta);
    out[i] = f.residual2(x);
  }
  return out;
}

}  // namespace veridyn
