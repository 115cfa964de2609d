#include "diagnosis/evidence/folds.hpp"

#include <algorithm>
#include <cmath>

#include "diagnosis/evidence/numerics.hpp"

namespace veridyn {
namespace {

// Mean square of every joint on a fold, from the others.
VectorXd held_out_error(const NormalBlocks& data, const ColumnSet& set, const VectorXd& w,
                        const NormalBlocks::Sums& fold) {
  const VectorXd x = data.solve(set, w, data.total(), &fold);
  return data.residual2(set, x, fold).array() / fold.rows.array().max(1.0);
}

}  // namespace

HoldOut hold_out(const Thresholds& limits) {
  return {static_cast<size_t>(std::lround(limits.fewest_folds)), limits.new_share};
}

std::vector<std::vector<int>> make_folds(const NormalBlocks& data, const HoldOut& hold_out) {
  size_t recordings = 0;
  for (int c = 0; c < data.clusters(); ++c)
    recordings = std::max(recordings, static_cast<size_t>(data.recording_of(c)) + 1);
  std::vector<std::vector<int>> folds;
  if (recordings == 1) {
    for (int c = 0; c < data.clusters(); ++c) folds.push_back({c});
    return folds;
  }
  std::vector<std::vector<int>> of_recording(recordings);
  for (int c = 0; c < data.clusters(); ++c) of_recording[data.recording_of(c)].push_back(c);
  const size_t each = hold_out.parts_of_each(recordings);
  for (const std::vector<int>& clusters : of_recording) {
    for (size_t part = 0; part < each; ++part) {
      const auto from = clusters.begin() + static_cast<long>(part * clusters.size() / each);
      const auto to = clusters.begin() + static_cast<long>((part + 1) * clusters.size() / each);
      if (from != to) folds.emplace_back(from, to);
    }
  }
  return folds;
}

NormalBlocks::Sums summed(const NormalBlocks& data, const std::vector<int>& clusters) {
  NormalBlocks::Sums out = data.cluster(clusters.front());
  for (size_t k = 1; k < clusters.size(); ++k) {
    const NormalBlocks::Sums& next = data.cluster(clusters[k]);
    for (size_t j = 0; j < out.G.size(); ++j) {
      out.G[j] += next.G[j];
      out.g[j] += next.g[j];
    }
    out.b2 += next.b2;
    out.rows += next.rows;
  }
  return out;
}

VectorXd joint_weights(const NormalBlocks& data, const ColumnSet& set) {
  const NormalBlocks::Sums& all = data.total();
  VectorXd w = all.rows.array() / all.b2.array().max(numerics::kTiny);
  for (int round = 0; round < 2; ++round) {
    const VectorXd x = data.solve(set, w, all, nullptr);
    w = all.rows.array() /
        data.residual2(set, x, all).array().max(numerics::kNoise * all.b2.array().max(numerics::kTiny));
  }
  return w;
}

double log_fall(const VectorXd& before, const VectorXd& after) {
  return (before.array().max(numerics::kTiny).min(numerics::kHuge).log() -
          after.array().max(numerics::kTiny).min(numerics::kHuge).log())
      .sum();
}

double fold_gain(const NormalBlocks& before, const ColumnSet& base_before,
                 const NormalBlocks& after, const ColumnSet& base_after, const HoldOut& hold_out) {
  const VectorXd w_before = joint_weights(before, base_before);
  const VectorXd w_after = joint_weights(after, base_after);
  const auto folds = make_folds(before, hold_out);
  double sum = 0.0;
  for (const auto& fold : folds) {
    sum += log_fall(held_out_error(before, base_before, w_before, summed(before, fold)),
                    held_out_error(after, base_after, w_after, summed(after, fold)));
  }
  return sum / static_cast<double>(folds.size());
}

}  // namespace veridyn
