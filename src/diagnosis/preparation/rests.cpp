#include <algorithm>
#include <cmath>

#include "diagnosis/preparation/diagnosis_state.hpp"
#include "model/correlated_joints.hpp"

// Reports joints whose effects the recorded motion cannot separate, before any cause is tested.

namespace veridyn {
namespace {

// Largest speed of every joint, over all recordings.
std::vector<double> largest_speeds(const std::vector<RecordingError>& recordings, size_t joints) {
  std::vector<double> out(joints, 0.0);
  for (const RecordingError& r : recordings) {
    for (size_t i = 0; i < joints; ++i) {
      for (const double v : r.series.dq[i]) out[i] = std::max(out[i], std::abs(v));
    }
  }
  return out;
}

// True if a joint is faster at sample k than `share` of its largest speed.
bool is_moving_at(const PredictionSeries& x, size_t k, const std::vector<double>& speeds, double share) {
  for (size_t i = 0; i < speeds.size(); ++i) {
    if (std::abs(x.dq[i][k]) > share * speeds[i]) return true;
  }
  return false;
}

// Adds the rests at the beginning and at the end of a recording.
void add_rests_at_ends(const RecordingError& r, const std::vector<double>& speeds, const Thresholds& limits,
              std::vector<ExcludedInterval>& out) {
  const PredictionSeries& x = r.series;
  size_t first = 0;
  while (first < x.time.size() && !is_moving_at(x, first, speeds, limits.moving_share)) ++first;
  if (first == x.time.size()) return;  // the arm never moves: a recording of poses
  size_t last = x.time.size() - 1;
  while (!is_moving_at(x, last, speeds, limits.moving_share)) --last;
  if (x.time[first] - x.time.front() > limits.shortest_rest)
    out.push_back({r.source, {}, 0.0, x.time[first], "the arm rests at the start"});
  if (x.time.back() - x.time[last] > limits.shortest_rest)
    out.push_back({r.source, {}, x.time[last], r.series.time.back() + limits.shortest_rest,
                   "the arm rests at the end"});
}

// Groups of joints whose positions are nearly linear functions of each other.
std::vector<std::vector<JointIndex>> moving_as_one(const Identification& id, const Thresholds& limits) {
  const int n = id.model->joints();
  Eigen::Index rows = 0;
  for (const RecordingError& r : id.train) rows += static_cast<Eigen::Index>(r.series.time.size());
  MatrixXd q(rows, n);
  for (int j = 0; j < n; ++j) {
    Eigen::Index row = 0;
    for (const RecordingError& r : id.train) {
      for (const double value : r.series.q[j]) q(row++, j) = value;
    }
    const bool slides = id.model->coordinates()[j].prismatic;
    if (q.col(j).maxCoeff() - q.col(j).minCoeff() <= limits.still(slides)) q.col(j).setZero();
  }
  return correlated_joints(q, limits.move_as_one);
}

}  // namespace

void exclude_rests(DiagnosisState& x) {
  const Identification& seen = x.d.baseline;
  x.d.moving_as_one = moving_as_one(seen, x.options.thresholds);
  const std::vector<double> speeds = largest_speeds(seen.train, static_cast<size_t>(seen.model->joints()));
  std::vector<ExcludedInterval> rests;
  for (const RecordingError& r : seen.train) add_rests_at_ends(r, speeds, x.options.thresholds, rests);
  if (rests.empty()) return;
  const IdentificationOptions before = x.options.identification;
  const size_t parts = x.d.excluded_intervals.size();
  leave_out(rests, x);
  const Identification without = x.fit(x.arm);
  if (!without.model) {  // too few rows remain
    x.options.identification = before;
    x.d.excluded_intervals.resize(parts);
    return;
  }
  x.d.baseline = without;
  x.start = x.d.baseline;
}

}  // namespace veridyn
