#include <algorithm>
#include <cmath>
#include <tuple>

#include "excitation/search/motion_search.hpp"

namespace veridyn {
namespace {

constexpr int kInstantsPerWave = 64;

// Range of a signal, enlarged by its curvature between instants. A signal that does not repeat is constant
// before its first and after its last sample.
std::pair<double, double> range_of(const VectorXd& v, bool periodic) {
  const Eigen::Index rows = v.size();
  double low = v.minCoeff();
  double high = v.maxCoeff();
  const auto bend = [&](Eigen::Index k) {
    const double before = periodic || k > 0 ? v[(k + rows - 1) % rows] : v[k];
    const double after = periodic || k + 1 < rows ? v[(k + 1) % rows] : v[k];
    return std::abs(before - 2.0 * v[k] + after) / 8.0;
  };
  for (Eigen::Index k = 0; k < rows; ++k) {
    if (!periodic && k + 1 == rows) break;
    const Eigen::Index next = (k + 1) % rows;
    const double extra = std::max(bend(k), bend(next));
    low = std::min(low, std::min(v[k], v[next]) - extra);
    high = std::max(high, std::max(v[k], v[next]) + extra);
  }
  return {low, high};
}

// Margins of every signal with a limit; `range` computes the smallest and the largest value of a signal.
template <typename Range>
std::vector<LimitMargin> margins_of(const LimitSignals& signals, const Range& range) {
  std::vector<LimitMargin> out;
  for (int k = 0; k < signals.count(); ++k) {
    const LimitSignal& signal = signals[k];
    if (!std::isfinite(signal.lower) && !std::isfinite(signal.upper)) continue;
    LimitMargin m{signal.name, signal.unit};
    m.lower = signal.lower;
    m.upper = signal.upper;
    std::tie(m.lowest, m.highest) = range(k);
    m.margin = std::min(m.lowest - m.lower, m.upper - m.highest);
    m.kind = signal.kind;
    m.joint = signal.joint;
    out.push_back(m);
  }
  return out;
}

}  // namespace

std::vector<LimitMargin> limit_margins(const LimitSignals& signals,
                                       const FourierTrajectory& trajectory) {
  const int n = signals.joints();
  const MotionBounds bounds = trajectory.bounds();
  MatrixXd others;
  if (signals.count() > 3 * n) {
    const int instants = std::max(400, kInstantsPerWave * trajectory.harmonics());
    others = signals.values(trajectory.samples(period_instants(trajectory.frequency(), instants)));
  }
  return margins_of(signals, [&](int k) -> std::pair<double, double> {
    if (k < n) return {bounds.lower[k], bounds.upper[k]};
    if (k >= 3 * n) return range_of(others.col(k - 3 * n), true);
    const double largest = k < 2 * n ? bounds.velocity[k - n] : bounds.acceleration[k - 2 * n];
    return {-largest, largest};
  });
}

std::vector<LimitMargin> limit_margins(const LimitSignals& signals, const MotionSamples& motion) {
  const int n = signals.joints();
  MatrixXd all(motion.rows(), signals.count());
  all.leftCols(3 * n) << motion.q, motion.dq, motion.ddq;
  if (signals.count() > 3 * n) all.rightCols(signals.count() - 3 * n) = signals.values(motion);
  return margins_of(signals, [&](int k) { return range_of(all.col(k), false); });
}

std::vector<LimitMargin> joined(const std::vector<LimitMargin>& first,
                                const std::vector<LimitMargin>& second) {
  std::vector<LimitMargin> out = first;
  for (size_t k = 0; k < std::min(first.size(), second.size()); ++k) {
    out[k].lowest = std::min(first[k].lowest, second[k].lowest);
    out[k].highest = std::max(first[k].highest, second[k].highest);
    out[k].margin = std::min(first[k].margin, second[k].margin);
  }
  return out;
}

}  // namespace veridyn
