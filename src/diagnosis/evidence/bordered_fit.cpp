#include "diagnosis/evidence/bordered_fit.hpp"

#include <algorithm>

#include "diagnosis/numerics.hpp"

namespace veridyn {
namespace {

MatrixXd gathered(const MatrixXd& G, const ColumnSet& rows, const ColumnSet& columns) {
  MatrixXd out(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(columns.size()));
  for (Eigen::Index c = 0; c < out.cols(); ++c) {
    const auto column = G.col(columns[static_cast<size_t>(c)]);
    for (Eigen::Index r = 0; r < out.rows(); ++r) out(r, c) = column[rows[static_cast<size_t>(r)]];
  }
  return out;
}

VectorXd gathered(const VectorXd& g, const ColumnSet& rows) {
  VectorXd out(static_cast<Eigen::Index>(rows.size()));
  for (Eigen::Index r = 0; r < out.size(); ++r) out[r] = g[rows[static_cast<size_t>(r)]];
  return out;
}

}  // namespace

BorderedFit::BorderedFit(const ColumnSet& set, const VectorXd& weights,
                         const NormalBlocks::Sums& sums, const NormalBlocks::Sums* without,
                         const NormalBlocks::Sums* measure)
    : set_(set), weights_(weights), sums_(sums), without_(without), measure_(measure) {
  x_.resize(static_cast<Eigen::Index>(set.size()));
  if (!set.empty()) {
    solver_ = RidgedSolver(weighted(set, set));
    x_ = solver_.solve(weighted(set));
  }
  if (measure == nullptr) return;
  residual2_ = measure->b2;
  for (size_t j = 0; j < measure->G.size(); ++j) {
    G_.push_back(gathered(measure->G[j], set, set));
    const VectorXd g = gathered(measure->g[j], set);
    Gx_.push_back(G_.back() * x_ - g);
    const auto at = static_cast<Eigen::Index>(j);
    residual2_[at] = std::max(residual2_[at] + x_.dot(Gx_.back() - g), 0.0);
  }
}

MatrixXd BorderedFit::weighted(const ColumnSet& rows, const ColumnSet& columns) const {
  MatrixXd out = MatrixXd::Zero(static_cast<Eigen::Index>(rows.size()),
                                static_cast<Eigen::Index>(columns.size()));
  for (size_t j = 0; j < sums_.G.size(); ++j) {
    const double w = weights_[static_cast<Eigen::Index>(j)];
    out += w * gathered(sums_.G[j], rows, columns);
    if (without_ != nullptr) out -= w * gathered(without_->G[j], rows, columns);
  }
  return out;
}

VectorXd BorderedFit::weighted(const ColumnSet& rows) const {
  VectorXd out = VectorXd::Zero(static_cast<Eigen::Index>(rows.size()));
  for (size_t j = 0; j < sums_.g.size(); ++j) {
    const double w = weights_[static_cast<Eigen::Index>(j)];
    out += w * gathered(sums_.g[j], rows);
    if (without_ != nullptr) out -= w * gathered(without_->g[j], rows);
  }
  return out;
}

BorderedFit::Border BorderedFit::with(const ColumnSet& more) const {
  Border out;
  MatrixXd S = weighted(more, more);
  const VectorXd squares = S.diagonal().cwiseMax(numerics::kTiny);
  VectorXd rest = weighted(more);
  MatrixXd D;
  if (!set_.empty()) {
    const MatrixXd C = weighted(set_, more);
    D = solver_.solve_columns(C);
    S -= C.transpose() * D;
    rest -= C.transpose() * x_;
  }
  out.new_share = (S.diagonal().array() / squares.array()).maxCoeff();
  S.diagonal() += numerics::kRidge * squares;
  out.values = RidgedSolver(S).solve(rest);
  if (measure_ == nullptr) return out;
  // z = [x - D y; y]: the change against [x; 0] in the quadratic form of every joint.
  const VectorXd d = set_.empty() ? VectorXd() : VectorXd(-D * out.values);
  out.residual2 = residual2_;
  for (size_t j = 0; j < measure_->G.size(); ++j) {
    const MatrixXd own = gathered(measure_->G[j], more, more);
    const VectorXd& y = out.values;
    double change = y.dot(own * y) - 2.0 * y.dot(gathered(measure_->g[j], more));
    if (!set_.empty()) {
      const MatrixXd cross = gathered(measure_->G[j], set_, more);
      change += d.dot(G_[j] * d) + 2.0 * d.dot(Gx_[j]) + 2.0 * (x_ + d).dot(cross * y);
    }
    double& r2 = out.residual2[static_cast<Eigen::Index>(j)];
    r2 = std::max(r2 + change, 0.0);
  }
  return out;
}

}  // namespace veridyn
