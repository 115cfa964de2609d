#include "diagnosis/evidence/bordered_fit.hpp"

#include <algorithm>

#include "diagnosis/evidence/numerics.hpp"

namespace veridyn {
namespace {

// Submatrix of a joint for these rows and columns.
MatrixXd gathered(const JointSquares& G, const OwnColumns& rows, const OwnColumns& columns) {
  MatrixXd out(rows.size(), columns.size());
  for (Eigen::Index c = 0; c < out.cols(); ++c) {
    const auto column = G.values().col(columns.in_joint[c]);
    for (Eigen::Index r = 0; r < out.rows(); ++r)
      out(r, c) = column[rows.in_joint[r]];
  }
  return out;
}

VectorXd gathered(const VectorXd& g, const ColumnSet& set, const OwnColumns& rows) {
  VectorXd out(rows.size());
  for (Eigen::Index r = 0; r < out.size(); ++r)
    out[r] = g[set[rows.in_set[r]]];
  return out;
}

// Entries of a vector over the whole set that act on a joint.
VectorXd seen(const VectorXd& x, const OwnColumns& own) {
  VectorXd out(own.size());
  for (Eigen::Index r = 0; r < out.size(); ++r) out[r] = x[own.in_set[r]];
  return out;
}

void add_columns(double weight, const JointSquares& G, const OwnColumns& rows,
                 const OwnColumns& columns, MatrixXd& to) {
  for (size_t c = 0; c < columns.in_set.size(); ++c) {
    const auto column = G.values().col(columns.in_joint[c]);
    auto sum = to.col(columns.in_set[c]);
    for (size_t r = 0; r < rows.in_set.size(); ++r)
      sum[rows.in_set[r]] += weight * column[rows.in_joint[r]];
  }
}

}  // namespace

BorderedFit::BorderedFit(const ColumnSet& set, const VectorXd& weights,
                         const NormalBlocks::Sums& sums, const NormalBlocks::Sums* without,
                         const NormalBlocks::Sums* measure)
    : set_(set), weights_(weights), sums_(sums), without_(without), measure_(measure) {
  for (const JointSquares& G : sums.G) own_.emplace_back(set, G);
  x_.resize(static_cast<Eigen::Index>(set.size()));
  if (!set.empty()) {
    solver_ = RidgedSolver(weighted(set, own_, set, own_));
    x_ = solver_.solve(weighted(set));
  }
  if (measure == nullptr) return;
  residual2_ = measure->b2;
  for (size_t j = 0; j < measure->G.size(); ++j) {
    G_.push_back(gathered(measure->G[j], own_[j], own_[j]));
    const VectorXd g = gathered(measure->g[j], set, own_[j]);
    const VectorXd x = seen(x_, own_[j]);
    Gx_.push_back(G_.back() * x - g);
    const auto at = static_cast<Eigen::Index>(j);
    residual2_[at] = std::max(residual2_[at] + x.dot(Gx_.back() - g), 0.0);
  }
}

MatrixXd BorderedFit::weighted(const ColumnSet& rows, const std::vector<OwnColumns>& own_rows,
                               const ColumnSet& columns,
                               const std::vector<OwnColumns>& own_columns) const {
  MatrixXd out = MatrixXd::Zero(rows.size(),
                                static_cast<Eigen::Index>(columns.size()));
  for (size_t j = 0; j < sums_.G.size(); ++j) {
    const double w = weights_[static_cast<Eigen::Index>(j)];
    add_columns(w, sums_.G[j], own_rows[j], own_columns[j], out);
    if (without_ != nullptr) add_columns(-w, without_->G[j], own_rows[j], own_columns[j], out);
  }
  return out;
}

VectorXd BorderedFit::weighted(const ColumnSet& rows) const {
  VectorXd out = VectorXd::Zero(rows.size());
  for (size_t j = 0; j < sums_.g.size(); ++j) {
    const double w = weights_[static_cast<Eigen::Index>(j)];
    for (Eigen::Index r = 0; r < out.size(); ++r) {
      const int row = rows[r];
      out[r] += w * (sums_.g[j][row] - (without_ != nullptr ? without_->g[j][row] : 0.0));
    }
  }
  return out;
}

BorderedFit::Border BorderedFit::with(const ColumnSet& more) const {
  Border out;
  std::vector<OwnColumns> own_more;
  for (const JointSquares& G : sums_.G) own_more.emplace_back(more, G);
  MatrixXd S = weighted(more, own_more, more, own_more);
  const VectorXd squares = S.diagonal().cwiseMax(numerics::kTiny);
  VectorXd rest = weighted(more);
  MatrixXd D;
  if (!set_.empty()) {
    const MatrixXd C = weighted(set_, own_, more, own_more);
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
    double change = 0.0;
    if (!set_.empty()) {
      const VectorXd own_d = seen(d, own_[j]);
      // Half of G is read: this product waits for memory.
      const VectorXd Gd = G_[j].selfadjointView<Eigen::Lower>() * own_d;
      change += own_d.dot(Gd + 2.0 * Gx_[j]);
    }
    if (own_more[j].size() > 0) {
      const VectorXd y = seen(out.values, own_more[j]);
      const MatrixXd own = gathered(measure_->G[j], own_more[j], own_more[j]);
      change += y.dot(own * y - 2.0 * gathered(measure_->g[j], more, own_more[j]));
      if (own_[j].size() > 0) {
        const MatrixXd cross = gathered(measure_->G[j], own_[j], own_more[j]);
        change += 2.0 * seen(x_ + d, own_[j]).dot(cross * y);
      }
    }
    double& r2 = out.residual2[static_cast<Eigen::Index>(j)];
    r2 = std::max(r2 + change, 0.0);
  }
  return out;
}

}  // namespace veridyn
