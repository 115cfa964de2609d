#include "diagnosis/evidence/normal_blocks.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "diagnosis/evidence/clustered_fit.hpp"
#include "diagnosis/evidence/numerics.hpp"

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

using PlacesOfJoints = std::vector<std::shared_ptr<const JointSquares::Places>>;

NormalBlocks::Sums empty(const PlacesOfJoints& places, Eigen::Index columns) {
  const auto joints = static_cast<Eigen::Index>(places.size());
  return {std::vector<JointSquares>(places.begin(), places.end()),
          std::vector<VectorXd>(places.size(), VectorXd::Zero(columns)), VectorXd::Zero(joints),
          VectorXd::Zero(joints)};
}

// The columns that some factor of a joint has, in the order of all columns.
PlacesOfJoints places_of(const std::vector<CompressedRecording>& recordings,
                         const std::unordered_map<std::string, int>& index, size_t joints) {
  PlacesOfJoints out;
  for (size_t j = 0; j < joints; ++j) {
    auto places = std::make_shared<JointSquares::Places>();
    places->local_of.assign(index.size(), -1);
    for (const CompressedRecording& recording : recordings) {
      for (const auto& block : recording.blocks) {
        for (const std::string& name : block[j].columns()) {
          const auto found = index.find(name);
          if (found != index.end()) places->local_of[found->second] = 0;
        }
      }
    }
    for (size_t c = 0; c < places->local_of.size(); ++c) {
      if (places->local_of[c] < 0) continue;
      places->local_of[c] = static_cast<int>(places->column_of.size());
      places->column_of.push_back(static_cast<int>(c));
    }
    out.push_back(std::move(places));
  }
  return out;
}

// Adds one factor's entries for the requested columns.
void enter(const SquareRootInformation& factor, const std::unordered_map<std::string, int>& index,
           JointSquares& G, VectorXd& g) {
  const VectorXd mixed = factor.R().transpose() * factor.z();
  std::vector<int> from;
  std::vector<int> to;
  for (int a = 0; a < factor.size(); ++a) {
    const auto found = index.find(factor.columns()[a]);
    if (found == index.end()) continue;
    from.push_back(a);
    to.push_back(G.local(found->second));
    g[found->second] = mixed[a];
  }
  MatrixXd squares = MatrixXd::Zero(factor.size(), factor.size());
  squares.selfadjointView<Eigen::Lower>().rankUpdate(factor.R().transpose());
  for (size_t b = 0; b < from.size(); ++b) {
    for (size_t a = b; a < from.size(); ++a)
      G.values()(to[a], to[b]) = G.values()(to[b], to[a]) = squares(from[a], from[b]);
  }
}

}  // namespace

NormalBlocks::NormalBlocks(const std::vector<CompressedRecording>& recordings,
                           std::vector<std::string> columns, const VectorXd& scale)
    : NormalBlocks(recordings, std::move(columns), scale, nullptr) {}

NormalBlocks::NormalBlocks(std::vector<CompressedRecording>& recordings,
                           std::vector<std::string> columns, EmptiedFactors)
    : NormalBlocks(recordings, std::move(columns), {}, &recordings) {}

NormalBlocks::NormalBlocks(const std::vector<CompressedRecording>& recordings,
                           std::vector<std::string> columns, const VectorXd& scale,
                           std::vector<CompressedRecording>* emptied)
    : names_(std::move(columns)), joints_(static_cast<int>(recordings.front().joints.size())) {
  std::unordered_map<std::string, int> index;
  for (size_t k = 0; k < names_.size(); ++k) index.emplace(names_[k], static_cast<int>(k));
  const auto count = static_cast<Eigen::Index>(names_.size());
  const PlacesOfJoints places = places_of(recordings, index, static_cast<size_t>(joints_));
  total_ = empty(places, count);
  for (size_t r = 0; r < recordings.size(); ++r) {
    for (size_t k = 0; k < recordings[r].blocks.size(); ++k) {
      const std::vector<SquareRootInformation>& block = recordings[r].blocks[k];
      Sums sums = empty(places, count);
      for (int j = 0; j < joints_; ++j) {
        const auto at = static_cast<size_t>(j);
        enter(block[at], index, sums.G[at], sums.g[at]);
        sums.b2[j] = block[at].rhs_norm2();
        sums.rows[j] = block[at].rows();
      }
      add(total_, sums);
      clusters_.push_back(std::move(sums));
      recording_of_.push_back(static_cast<int>(r));
      if (emptied != nullptr) std::vector<SquareRootInformation>().swap((*emptied)[r].blocks[k]);
    }
    if (emptied != nullptr) (*emptied)[r].blocks.clear();
  }
  scale_ = VectorXd::Zero(count);
  for (const JointSquares& G : total_.G) {
    for (size_t c = 0; c < G.columns().size(); ++c)
      scale_[G.columns()[c]] += G.values().diagonal()[static_cast<Eigen::Index>(c)];
  }
  scale_ = scale.size() > 0 ? scale : VectorXd(scale_.cwiseSqrt());
  const VectorXd inverse = (scale_.array() > 0.0).select(scale_.array().max(numerics::kTiny).inverse(), 0.0);
  const auto rescale = [&inverse](Sums& s) {
    for (size_t j = 0; j < s.G.size(); ++j) {
      VectorXd own(s.G[j].values().rows());
      for (Eigen::Index c = 0; c < own.size(); ++c)
        own[c] = inverse[s.G[j].columns()[c]];
      s.G[j].values().array() *= (own * own.transpose()).array();
      s.g[j].array() *= inverse.array();
    }
  };
  rescale(total_);
  for (Sums& s : clusters_) rescale(s);
}

OwnColumns::OwnColumns(const ColumnSet& set, const JointSquares& of) {
  for (size_t k = 0; k < set.size(); ++k) {
    const int local = of.local(set[k]);
    if (local < 0) continue;
    in_set.push_back(static_cast<Eigen::Index>(k));
    in_joint.push_back(local);
  }
}

VectorXd NormalBlocks::solve(const ColumnSet& set, const VectorXd& weights, const Sums& sums,
                             const Sums* without, const VectorXd& prior) const {
  const auto k = static_cast<Eigen::Index>(set.size());
  if (k == 0) return {};
  MatrixXd A = MatrixXd::Zero(k, k);
  VectorXd b = VectorXd::Zero(k);
  for (int j = 0; j < joints_; ++j) {
    const auto at = static_cast<size_t>(j);
    const double w = weights[j];
    const OwnColumns own(set, sums.G[at]);
    for (size_t c = 0; c < own.in_set.size(); ++c) {
      const int column = set[own.in_set[c]];
      const auto of_sums = sums.G[at].values().col(own.in_joint[c]);
      b[own.in_set[c]] +=
          w * (sums.g[at][column] - (without != nullptr ? without->g[at][column] : 0.0));
      if (without == nullptr) {
        for (size_t r = c; r < own.in_set.size(); ++r)
          A(own.in_set[r], own.in_set[c]) += w * of_sums[own.in_joint[r]];
        continue;
      }
      const auto of_without = without->G[at].values().col(own.in_joint[c]);
      for (size_t r = c; r < own.in_set.size(); ++r)
        A(own.in_set[r], own.in_set[c]) +=
            w * (of_sums[own.in_joint[r]] - of_without[own.in_joint[r]]);
    }
  }
  if (prior.size() > 0) A.diagonal() += prior;
  return RidgedSolver(std::move(A)).solve(b);
}

VectorXd NormalBlocks::residual2(const ColumnSet& set, const VectorXd& x, const Sums& sums) const {
  VectorXd out = sums.b2;
  for (int j = 0; j < joints_; ++j) {
    const auto at = static_cast<size_t>(j);
    const OwnColumns own(set, sums.G[at]);
    double quadratic = 0.0;
    double linear = 0.0;
    for (size_t c = 0; c < own.in_set.size(); ++c) {
      const double mine = x[own.in_set[c]];
      const auto column = sums.G[at].values().col(own.in_joint[c]);
      linear += mine * sums.g[at][set[own.in_set[c]]];
      double sum = 0.5 * column[own.in_joint[c]] * mine;
      for (size_t r = c + 1; r < own.in_set.size(); ++r)
        sum += column[own.in_joint[r]] * x[own.in_set[r]];
      quadratic += 2.0 * mine * sum;
    }
    out[j] = std::max(out[j] + quadratic - 2.0 * linear, 0.0);
  }
  return out;
}

}  // namespace veridyn
