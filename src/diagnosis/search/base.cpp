#include "diagnosis/search/base.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Eigenvalues>

#include "diagnosis/numerics.hpp"
#include "diagnosis/search/numbers.hpp"
#include "math/parallel.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/identification/base_parameters.hpp"
#include "veridyn/regressor/standard_parameters.hpp"

namespace veridyn::search {

MatrixXd base_columns(const Rows& rows, int joint, const MatrixXd& T) {
  MatrixXd of_joint(static_cast<Eigen::Index>(rows.own_parameters[joint].size()), T.cols());
  for (Eigen::Index k = 0; k < of_joint.rows(); ++k) of_joint.row(k) = T.row(rows.own_parameters[joint][k]);
  return rows.own[joint] * of_joint;
}

namespace {

// Adds to base.nonnegative and base.value the values of effects that have the lower bound zero.
void add_bounds(const Rows& rows, Base& base) {
  const std::vector<StandardParameter> all = standard_parameters(rows.arm());
  for (size_t p = 0; p < all.size(); ++p) {
    const auto at = static_cast<Eigen::Index>(p);
    if (!all[p].effect || all[p].lower != 0.0 || base.T.row(at).isZero(0.0)) continue;
    const Eigen::Index next = base.value.size();
    base.nonnegative.conservativeResize(next + 1, base.T.cols());
    base.nonnegative.row(next) = base.T.row(at);
    base.value.conservativeResize(next + 1);
    base.value[next] = std::max(all[p].value, 0.0);
  }
}

// Gram matrix of the columns of all parameters, each joint's torque relative to its rms.
MatrixXd gram_of(const Rows& rows, int threads = 1) {
  std::vector<MatrixXd> of_joint(rows.joints());
  parallel_for(rows.joints(), threads, [&](int i) {
    const double power = (rows.measured.col(i).array().square() * rows.used.col(i).array()).mean();
    if (power > 0.0) of_joint[i] = rows.own[i].transpose() * rows.used.col(i).asDiagonal() * rows.own[i] / power;
  });
  const auto all = static_cast<Eigen::Index>(rows.names().size());
  MatrixXd G = MatrixXd::Zero(all, all);
  for (int i = 0; i < rows.joints(); ++i) {
    if (of_joint[i].size() > 0) G(rows.own_parameters[i], rows.own_parameters[i]) += of_joint[i];
  }
  return G;
}

// Combinations of masses and first moments without torque under the MODEL's gravity but with torque under
// another one, such as the moments of an upright arm's first link. The MODEL does not determine them; their
// prior deviations are typical for an arm's bodies.
MatrixXd hidden_by_gravity(const Model& model) {
  const std::vector<StandardParameter> parameters = standard_parameters(model);
  const BaseParameters base = base_parameters(model);
  const auto all = static_cast<Eigen::Index>(parameters.size());
  MatrixXd N(all, 0);
  for (Eigen::Index p = 0; p < all; ++p) {
    if (!parameters[p].body || parameters[p].component > 3 || std::count(base.independent.begin(), base.independent.end(), p) > 0) continue;
    VectorXd none = VectorXd::Unit(all, p);
    for (size_t k = 0; k < base.independent.size(); ++k) none[base.independent[k]] -= base.K(static_cast<Eigen::Index>(k), p);
    N.conservativeResize(all, N.cols() + 1);
    N.rightCols(1) = none * (parameters[p].component == 0 ? kMassOfArm : kMassOfArm * kReach);
  }
  const double g = model.gravity().norm();
  if (N.cols() == 0 || g == 0.0) return MatrixXd(all, 0);
  MatrixXd G = MatrixXd::Zero(N.cols(), N.cols());
  for (int axis = 0; axis < 3; ++axis) {
    ModelDescription turned = model.description();
    turned.gravity = g * Eigen::Vector3d::Unit(axis);
    const MatrixXd R = random_state_factor(Model(std::move(turned)), kRandomStates, 1).R() * N;
    G += R.transpose() * R;
  }
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(G);
  const Eigen::Index kept = (eigen.eigenvalues().array() > kHidden * std::max(1.0, eigen.eigenvalues().maxCoeff())).count();
  return N * eigen.eigenvectors().rightCols(kept);
}

}  // namespace

MatrixXd covariance_of(const MatrixXd& F, const MatrixXd& G) {
  const double noise = kNoisePart * (F.transpose() * G * F).trace() / static_cast<double>(F.rows());
  const VectorXd bound = std::sqrt(kUncorrelatedPart) * F.rowwise().norm();
  MatrixXd precision = bound.asDiagonal() * G * bound.asDiagonal() / std::max(noise, numerics::kTiny);
  precision.diagonal().array() += 1.0;
  return F * F.transpose() + bound.asDiagonal() * precision.inverse() * bound.asDiagonal();
}

Base fitted_base(const Rows& rows, Eigen::Index most, int threads) {
  const MatrixXd G = gram_of(rows, threads);
  const VectorXd norm = G.diagonal().cwiseSqrt();
  const VectorXd inverse = (norm.array() > numerics::kNoise * norm.maxCoeff()).select(norm.array().max(numerics::kTiny).inverse(), 0.0);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(MatrixXd(inverse.asDiagonal() * G * inverse.asDiagonal()));
  const VectorXd& size = eigen.eigenvalues();
  Eigen::Index kept = 0;
  while (kept < std::min(most, size.size()) && size[size.size() - 1 - kept] > kDependent * size[size.size() - 1]) ++kept;
  Base out;
  out.T = inverse.asDiagonal() * eigen.eigenvectors().rightCols(kept) * size.tail(kept).cwiseSqrt().cwiseInverse().asDiagonal();
  // Keeps single parameters from having many times the measured torque while others cancel it.
  out.ridge = (kLargestPart * kLargestPart * static_cast<double>(rows.rows()) * size.tail(kept)).cwiseInverse();
  out.X.resize(rows.joints());
  parallel_for(rows.joints(), threads, [&](int i) { out.X[i] = base_columns(rows, i, out.T); });
  add_bounds(rows, out);
  return out;
}

Base prior_base(const Rows& rows, const Model& model) {
  const std::vector<std::string>& names = rows.names();
  const std::vector<StandardParameter> parameters = standard_parameters(model);
  std::vector<int> of;
  MatrixXd F;
  if (model.description().identified && model.description().identified->has_scatter()) {
    const IdentifiedBase& base = *model.description().identified;
    for (const IdentifiedParameter& p : base.parameters) {
      const auto at = std::find(names.begin(), names.end(), p.name);
      if (at == names.end() || p.scatter.size() == 0) continue;
      of.push_back(static_cast<int>(at - names.begin()));
      F.conservativeResize(static_cast<Eigen::Index>(of.size()), p.scatter.size());
      F.row(F.rows() - 1) = p.scatter;
    }
  }
  const auto find = [&](int parameter) {
    const auto at = std::find(of.begin(), of.end(), parameter);
    if (at != of.end()) return at - of.begin();
    of.push_back(parameter);
    return static_cast<std::ptrdiff_t>(of.size()) - 1;
  };
  std::vector<std::pair<Eigen::Index, double>> days;
  for (size_t p = 0; p < parameters.size(); ++p) {
    if (!parameters[p].effect) continue;
    const EffectTerm& term = model.effects()[*parameters[p].effect];
    if (!find_effect(term.effect).traits().elementary) continue;
    double level = std::abs(parameters[p].value);
    if (find_effect(term.effect).traits().role != EffectRole::kFriction) {
      // The prior of an offset's drift is a share of its joint's friction.
      for (size_t other = 0; other < parameters.size(); ++other) {
        if (!parameters[other].effect) continue;
        const EffectTerm& friction = model.effects()[*parameters[other].effect];
        if (find_effect(friction.effect).traits().dry == DryFriction::kConstant && friction.axis.coefficients == term.axis.coefficients)
          level = std::max(level, std::abs(parameters[other].value));
      }
    }
    days.emplace_back(find(static_cast<int>(p)), kDailyFrictionDeviation * level);
  }
  if (of.empty()) of.push_back(0);  // a file without statistics and friction: one direction that stays at zero
  const auto count = static_cast<Eigen::Index>(of.size());
  MatrixXd C = MatrixXd::Zero(count, count);
  if (F.size() > 0) {
    const MatrixXd all = gram_of(rows);
    MatrixXd G(F.rows(), F.rows());
    for (Eigen::Index c = 0; c < G.cols(); ++c) {
      for (Eigen::Index r = 0; r < G.rows(); ++r) G(r, c) = all(of[r], of[c]);
    }
    C.topLeftCorner(F.rows(), F.rows()) = covariance_of(F, G);
  }
  for (const auto& [at, deviation] : days) C(at, at) += deviation * deviation;
  const VectorXd size = C.diagonal().cwiseSqrt();
  const VectorXd inverse = (size.array() > 0.0).select(size.array().max(numerics::kTiny).inverse(), 0.0);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(MatrixXd(inverse.asDiagonal() * C * inverse.asDiagonal()));
  const MatrixXd L = size.asDiagonal() * eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
  const MatrixXd hidden = hidden_by_gravity(model);
  Base out;
  out.prior = true;
  out.hidden = hidden.cols();
  out.T = MatrixXd::Zero(static_cast<Eigen::Index>(names.size()), count + hidden.cols());
  for (Eigen::Index k = 0; k < count; ++k) out.T.row(of[k]).head(count) = L.row(k);
  out.T.rightCols(hidden.cols()) = hidden;
  out.ridge = VectorXd::Ones(out.T.cols());
  for (int i = 0; i < rows.joints(); ++i) out.X.push_back(base_columns(rows, i, out.T));
  return out;
}

}  // namespace veridyn::search
