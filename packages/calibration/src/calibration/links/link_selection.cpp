#include "calibration/links/link_selection.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "veridyn/identification/base_parameters.hpp"

namespace veridyn::internal {
namespace {

constexpr double kDependent = 1e-9;  // squared remainder of a column, relative to its square

// Bound of a parameter's uncertainty (two standard standard_deviations) for which fitting it is useful.
double uncertainty_bound(const LinkParameter& p) {
  return p.unit == "m" ? links_numbers.loose_length : p.unit == "rad" ? links_numbers.loose_angle : links_numbers.loose_ratio;
}

MatrixXd submatrix(const MatrixXd& N, const std::vector<int>& rows, const std::vector<int>& columns) {
  MatrixXd out(rows.size(), static_cast<Eigen::Index>(columns.size()));
  for (Eigen::Index i = 0; i < out.rows(); ++i) {
    for (Eigen::Index j = 0; j < out.cols(); ++j)
      out(i, j) = N(rows[i], columns[j]);
  }
  return out;
}

// The inverse of N over the active parameters, columns scaled to one first.
MatrixXd inverse_of(const MatrixXd& N, const std::vector<int>& active) {
  const MatrixXd A = submatrix(N, active, active);
  const VectorXd scale = A.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const MatrixXd scaled = scale.asDiagonal() * A * scale.asDiagonal();
  const MatrixXd identity = MatrixXd::Identity(A.rows(), A.cols());
  return scale.asDiagonal() * MatrixXd(scaled.ldlt().solve(identity)) * scale.asDiagonal();
}

// The independent parameters that a dependent one combines.
std::string combined_parameters(const LinkParameters& parameters, const BaseParameters& base, int column) {
  std::string names;
  int count = 0;
  for (int i = 0; i < base.size(); ++i) {
    if (base.K(i, column) == 0.0 || ++count > 4) continue;
    const int own = base.independent[i];
    names += (names.empty() ? "" : ", ") + parameters.all()[own].full_name();
  }
  if (count > 4) names += fmt::format(" and {} more", count - 4);
  return names;
}

// The largest uncertainty among the active parameters, relative to its bound, and its index. Poses of base
// and tool are never removed.
struct Loosest {
  int at = -1;
  double share = 0.0;
};

Loosest most_uncertain(const LinkParameters& parameters, const LinkNormal& normal,
                const std::vector<int>& active) {
  const VectorXd s = standard_deviations(normal, active);
  Loosest out;
  for (std::size_t k = 0; k < active.size(); ++k) {
    const LinkParameter& p = parameters.all()[active[k]];
    if (p.kind == LinkParameter::Kind::kBase || p.kind == LinkParameter::Kind::kTool) continue;
    const double share = 2.0 * s[static_cast<Eigen::Index>(k)] / uncertainty_bound(p);
    if (share > out.share) out = {static_cast<int>(k), share};
  }
  return out;
}

// Removes parameters whose uncertainty is too large, worst first. Afterwards a parameter that depended on
// them may be well determined: an encoder zero after two lengths of nearly equal effect. Such parameters are
// added, because their part of the errors would remain unexplained.
void drop_uncertain(const LinkParameters& parameters, const LinkNormal& normal, LinkChoice& out) {
  std::vector<int> removed;
  for (;;) {
    const Loosest worst = most_uncertain(parameters, normal, out.independent);
    if (worst.share < 1.0) break;
    const int p = out.independent[worst.at];
    out.why[p] = "hardly moves the tracked frame in these poses";
    removed.push_back(p);
    out.independent.erase(out.independent.begin() + worst.at);
  }
  if (removed.empty()) return;
  for (int k = 0; k < parameters.size(); ++k) {
    if (out.why[k].empty() || normal.N(k, k) <= 0.0 ||
        std::find(removed.begin(), removed.end(), k) != removed.end())
      continue;
    const double deviation = gains_of_adding(normal, out.independent)[k].deviation;
    if (deviation <= 0.0 || 2.0 * deviation > uncertainty_bound(parameters.all()[k])) continue;
    std::vector<int> with = out.independent;
    with.insert(std::upper_bound(with.begin(), with.end(), k), k);
    if (most_uncertain(parameters, normal, with).share >= 1.0) continue;
    out.independent = with;
    out.why[k].clear();
  }
}

}  // namespace

LinkChoice identifiable_links(const LinkParameters& parameters, const LinkNormal& normal, bool leave_out_loose) {
  std::vector<std::string> names;
  std::vector<int> preference;
  for (int k = 0; k < parameters.size(); ++k) {
    names.push_back("p" + std::to_string(k));
    preference.push_back(k);
  }
  // A factor of N: columns scaled to one, without small eigenvalues.
  const VectorXd scale = normal.N.diagonal().cwiseSqrt();
  const VectorXd inverse =
      scale.unaryExpr([](double s) { return s > 0.0 ? 1.0 / s : 0.0; });
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(
      MatrixXd(inverse.asDiagonal() * normal.N * inverse.asDiagonal()));
  const VectorXd roots = eigen.eigenvalues().unaryExpr(
      [&](double v) { return v > kDependent * eigen.eigenvalues().maxCoeff() ? std::sqrt(v) : 0.0; });
  const MatrixXd A =
      roots.asDiagonal() * eigen.eigenvectors().transpose() * scale.asDiagonal();
  SquareRootInformation factor(names);
  factor.absorb(A, VectorXd::Zero(A.rows()));
  const BaseParameters base = base_parameters(factor, preference);
  LinkChoice out;
  out.independent = base.independent;
  std::sort(out.independent.begin(), out.independent.end());
  out.rank_gap = base.rank_gap;
  out.why.assign(names.size(), "");
  for (int k = 0; k < parameters.size(); ++k) {
    const bool chosen = std::binary_search(out.independent.begin(), out.independent.end(), k);
    if (chosen) continue;
    out.why[k] =
        scale[k] <= 1e-12 * scale.maxCoeff()
            ? "does not move the tracked frame in these poses"
            : "cannot be told from " + combined_parameters(parameters, base, k);
  }
  if (leave_out_loose) drop_uncertain(parameters, normal, out);
  return out;
}

VectorXd standard_deviations(const LinkNormal& normal, const std::vector<int>& active) {
  if (active.empty()) return VectorXd();
  return inverse_of(normal.N, active).diagonal().cwiseMax(0.0).cwiseSqrt();
}

std::vector<LinkGain> gains_of_adding(const LinkNormal& normal, const std::vector<int>& active) {
  const auto p = static_cast<int>(normal.g.size());
  std::vector<int> all;
  for (int k = 0; k < p; ++k) all.push_back(k);
  MatrixXd N = normal.N;
  VectorXd g = normal.g;
  if (!active.empty()) {
    const MatrixXd C = submatrix(normal.N, all, active);
    const MatrixXd inverse = inverse_of(normal.N, active);
    VectorXd g_active(active.size());
    for (std::size_t k = 0; k < active.size(); ++k)
      g_active[static_cast<Eigen::Index>(k)] = normal.g[active[k]];
    N -= C * inverse * C.transpose();
    g -= C * inverse * g_active;
  }
  std::vector<LinkGain> out(p);
  for (int k = 0; k < p; ++k) {
    if (!(N(k, k) > kDependent * normal.N(k, k))) continue;
    if (std::find(active.begin(), active.end(), k) != active.end()) continue;
    out[k] = {g[k] * g[k] / N(k, k), -g[k] / N(k, k),
                                        1.0 / std::sqrt(N(k, k))};
  }
  return out;
}

}  // namespace veridyn::internal
