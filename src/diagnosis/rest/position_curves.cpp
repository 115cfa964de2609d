#include "diagnosis/rest/position_curves.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "diagnosis/findings/held_out.hpp"
#include "diagnosis/numerics.hpp"
#include "identification/estimation/additive_regression.hpp"

namespace veridyn {
namespace {

// Poses of all recordings in the order of their parts, which are held out together.
FoldedRows folded_poses(const Identification& at_rest, int joint, const HoldOut& how) {
  const std::vector<RecordingError>& all = at_rest.train;
  const size_t parts = how.parts_of_each(all.size()), most = 2 * how.parts_of_each(1);
  struct Pose {
    const PredictionSeries* of;
    size_t at, fold;
  };
  std::vector<Pose> poses;
  for (size_t r = 0; r < all.size(); ++r) {
    const size_t count = all[r].series.time.size();
    for (size_t k = 0; k < count; ++k) poses.push_back({&all[r].series, k, (r * parts + k * parts / count) % most});
  }
  std::stable_sort(poses.begin(), poses.end(), [](const Pose& a, const Pose& b) { return a.fold < b.fold; });
  FoldedRows out;
  const auto count = static_cast<Eigen::Index>(poses.size());
  out.signals.resize(count, at_rest.model->joints());
  out.response.resize(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Pose& pose = poses[k];
    for (int i = 0; i < at_rest.model->joints(); ++i) out.signals(k, i) = pose.of->q[i][pose.at];
    out.response[k] = pose.of->measured[joint][pose.at] - pose.of->modelled[joint][pose.at];
    if (k == 0 || pose.fold != poses[k - 1].fold) out.fold_begin.push_back(k);
  }
  out.fold_begin.push_back(count);
  return out;
}

// Of the joints that move.
std::vector<SmoothTerm> terms_of(const FoldedRows& rows, const Model& arm, const Thresholds& limits) {
  std::vector<int> moving;
  for (int i = 0; i < arm.joints(); ++i) {
    if (rows.signals.col(i).maxCoeff() - rows.signals.col(i).minCoeff() > limits.still(arm.coordinates()[i].prismatic)) moving.push_back(i);
  }
  const auto basis = [&](int i, int intervals) {
    return SmoothBasis(BasisKind::kSmooth, rows.signals.col(i).minCoeff(), rows.signals.col(i).maxCoeff(), intervals, 0.0);
  };
  std::vector<SmoothTerm> out;
  for (const int i : moving) out.push_back({{i}, {basis(i, numerics::kIntervals)}});
  for (size_t a = 0; a < moving.size(); ++a) {
    for (size_t b = a + 1; b < moving.size(); ++b)
      out.push_back({{moving[a], moving[b]}, {basis(moving[a], numerics::kIntervalsOfTwo), basis(moving[b], numerics::kIntervalsOfTwo)}, limits.unnamed_two_signals});
  }
  return out;
}

}  // namespace

double predicted_by_positions(const Identification& at_rest, int joint, const Thresholds& limits) {
  const FoldedRows rows = folded_poses(at_rest, joint, hold_out(limits));
  if (rows.fold_begin.size() < 3) return 0.0;
  const std::vector<SmoothTerm> terms = terms_of(rows, *at_rest.model, limits);
  std::vector<MatrixXd> columns;
  for (const SmoothTerm& term : terms) columns.push_back(term.columns(rows.signals));
  const AdditiveOptions how{static_cast<int>(limits.unnamed_terms), limits.unnamed_gain, limits.significance};
  const EstimationNumbers numbers;
  const AdditiveModel found = additive_regression(rows, terms, columns, how, numbers);
  if (found.chosen.empty()) return 0.0;
  return 1.0 - std::exp(-additive_fit(rows, terms, columns, found.chosen, numbers).gain);
}

}  // namespace veridyn
