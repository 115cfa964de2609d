#include "diagnosis/evidence/normal_blocks.hpp"

#include <cmath>
#include <unordered_map>
#include <utility>

#include "diagnosis/evidence/clustered_fit.hpp"
#include "diagnosis/numerics.hpp"

namespace veridyn {
namespace {

void add(NormalBlocks::Sums& to, const NormalBlocks::Sums& from) {
  for (size_t j = 0; j < to.G.size(); ++j) {
    to.G[j] += from.G[j];
    to.g[j] += from.g[j];
  }
  to.b2 += from.b2;
  to.rows += from.rows;
}

NormalBlocks::Sums empty(int joints, Eigen::Index columns) {
  return {std::vector<MatrixXd>(static_cast<size_t>(joints), MatrixXd::Zero(columns, columns)),
          std::vector<VectorXd>(static_cast<size_t>(joints), VectorXd::Zero(columns)),
          VectorXd::Zero(joints), VectorXd::Zero(joints)};
}

}  // namespace

NormalBlocks::NormalBlocks(const std::vector<CompressedRecording>& recordings,
                           std::vector<std::string> columns, const VectorXd& scale)
    : names_(std::move(columns)), joints_(static_cast<int>(recordings.front().joints.size())) {
  std::unordered_map<std::string, Eigen::Index> index;
  for (size_t k = 0; k < names_.size(); ++k) index.emplace(names_[k], static_cast<Eigen::Index>(k));
  const auto count = static_cast<Eigen::Index>(names_.size());
  total_ = empty(joints_, count);
  for (size_t r = 0; r < recordings.size(); ++r) {
    for (const auto& block : recordings[r].blocks) {
      Sums sums = empty(joints_, count);
      for (int j = 0; j < joints_; ++j) {
        const SquareRootInformation& factor = block[static_cast<size_t>(j)];
        const MatrixXd G = factor.R().transpose() * factor.R();
        const VectorXd g = factor.R().transpose() * factor.z();
        std::vector<Eigen::Index> at;
        for (const std::string& name : factor.columns()) {
          const auto found = index.find(name);
          at.push_back(found == index.end() ? -1 : found->second);
        }
        for (Eigen::Index a = 0; a < G.rows(); ++a) {
          const Eigen::Index row = at[static_cast<size_t>(a)];
          if (row < 0) continue;
          sums.g[static_cast<size_t>(j)][row] = g[a];
          for (Eigen::Index b = 0; b < G.cols(); ++b) {
            if (at[static_cast<size_t>(b)] >= 0)
              sums.G[static_cast<size_t>(j)](row, at[static_cast<size_t>(b)]) = G(a, b);
          }
        }
        sums.b2[j] = factor.rhs_norm2();
        sums.rows[j] = factor.rows();
      }
      add(total_, sums);
      clusters_.push_back(std::move(sums));
      recording_of_.push_back(static_cast<int>(r));
    }
  }
  scale_ = VectorXd::Zero(count);
  for (const MatrixXd& G : total_.G) scale_ += G.diagonal();
  scale_ = scale.size() > 0 ? scale : VectorXd(scale_.cwiseSqrt());
  const VectorXd inverse = (scale_.array() > 0.0).select(scale_.array().max(numerics::kTiny).inverse(), 0.0);
  const auto rescale = [&inverse](Sums& s) {
    for (size_t j = 0; j < s.G.size(); ++j) {
      s.G[j] = inverse.asDiagonal() * s.G[j] * inverse.asDiagonal();
      s.g[j] = inverse.asDiagonal() * s.g[j];
    }
  };
  rescale(total_);
  for (Sums& s : clusters_) rescale(s);
}

VectorXd NormalBlocks::solve(const ColumnSet& set, const VectorXd& weights, const Sums& sums,
                             const Sums* without) const {
  const auto k = static_cast<Eigen::Index>(set.size());
  if (k == 0) return {};
  MatrixXd A = MatrixXd::Zero(k, k);
  VectorXd b = VectorXd::Zero(k);
  for (int j = 0; j < joints_; ++j) {
    const auto at = static_cast<size_t>(j);
    const double w = weights[j];
    for (Eigen::Index c = 0; c < k; ++c) {
      const int column = set[static_cast<size_t>(c)];
      b[c] += w * (sums.g[at][column] - (without != nullptr ? without->g[at][column] : 0.0));
      for (Eigen::Index r = c; r < k; ++r) {
        const int row = set[static_cast<size_t>(r)];
        A(r, c) += w * (sums.G[at](row, column) -
                        (without != nullptr ? without->G[at](row, column) : 0.0));
      }
    }
  }
  return RidgedSolver(std::move(A)).solve(b);
}

VectorXd NormalBlocks::residual2(const ColumnSet& set, const VectorXd& x, const Sums& sums) const {
  const auto k = static_cast<Eigen::Index>(set.size());
  VectorXd out = sums.b2;
  for (int j = 0; j < joints_; ++j) {
    const auto at = static_cast<size_t>(j);
    double quadratic = 0.0;
    double linear = 0.0;
    for (Eigen::Index c = 0; c < k; ++c) {
      const int column = set[static_cast<size_t>(c)];
      linear += x[c] * sums.g[at][column];
      double sum = 0.5 * sums.G[at](column, column) * x[c];
      for (Eigen::Index r = c + 1; r < k; ++r)
        sum += sums.G[at](set[static_cast<size_t>(r)], column) * x[r];
      quadratic += 2.0 * x[c] * sum;
    }
    out[j] = std::max(out[j] + quadratic - 2.0 * linear, 0.0);
  }
  return out;
}

}  // namespace veridyn
