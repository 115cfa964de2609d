#include "recordings/breakaway_ramps.hpp"

#include <algorithm>
#include <cmath>

namespace veridyn {
namespace {

constexpr double kStillShare = 0.2;  // share of the displacement by which a joint at rest may creep
constexpr double kJumpShare = 5.0;   // number of displacements between two rows from which on they mark a new start
constexpr double kStartsBelow = 0.6;  // share of the effort at the onset below which a ramp starts
constexpr double kWindow = 0.05;      // [s] half width of the means of effort and speed
constexpr double kLeapShare = 0.7;    // share of the effort at the onset that counts as a leap
constexpr double kLeapSeconds = 0.2;  // [s] duration of a leap
// Distance from an end of the range, in displacements, within which the joint is at the stop.
constexpr double kNearEnd = 2.0;

// Rows within kWindow of row k.
struct Window {
  Eigen::Index from, to;
};

// Rows first .. end - 1 that are within kWindow [s] of row k.
Window window_around(const VectorXd& time, Eigen::Index k, Eigen::Index first, Eigen::Index end) {
  Window w{k, k};
  while (w.from > first && time[k] - time[w.from - 1] <= kWindow) --w.from;
  while (w.to + 1 < end && time[w.to + 1] - time[k] <= kWindow) ++w.to;
  return w;
}

// True if the mean speed about row k of a ramp is above `speed`.
bool is_sliding_at(const VectorXd& time, const VectorXd& q, const Ramp& ramp, Eigen::Index k,
            double speed) {
  const Window w = window_around(time, k, ramp.rest, ramp.end);
  return w.to > w.from && std::abs(q[w.to] - q[w.from]) > speed * (time[w.to] - time[w.from]);
}

// The row at which sliding began, for a joint that has left its rest by row k; ramp.end if it did not slide.
Eigen::Index onset_of(const VectorXd& time, const VectorXd& q, const Ramp& ramp, Eigen::Index k,
                      double speed) {
  if (!is_sliding_at(time, q, ramp, k, speed)) {
    while (k < ramp.end && !is_sliding_at(time, q, ramp, k, speed)) ++k;
    return k;
  }
  while (k > ramp.rest && is_sliding_at(time, q, ramp, k - 1, speed)) --k;
  return k;
}

Eigen::Index row_after_last_leap(const VectorXd& time, const VectorXd& tau, const Ramp& ramp) {
  const double leap = kLeapShare * std::abs(effort_at(time, tau, ramp.onset));
  Eigen::Index before = ramp.onset;
  for (Eigen::Index k = ramp.onset; k > ramp.rest; --k) {
    while (before > ramp.rest && time[k] - time[before] < kLeapSeconds) --before;
    const double change = effort_at(time, tau, k) - effort_at(time, tau, before);
    if (std::abs(change) > leap) return k;
  }
  return ramp.rest;
}

bool is_ramp(const Coordinate& joint, const VectorXd& time, const VectorXd& q, const VectorXd& tau,
             const Ramp& ramp, const RampThresholds& limit) {
  if (ramp.onset >= ramp.end || time[ramp.onset] - time[ramp.rest] < limit.rest) return false;
  const double first = effort_at(time, tau, ramp.rest);
  const double last = effort_at(time, tau, ramp.onset);
  if (last * first > kStartsBelow * last * last) return false;
  const double home = q[ramp.rest];
  return first > 0.0 ? home < joint.limits.upper - kNearEnd * limit.way
                     : home > joint.limits.lower + kNearEnd * limit.way;
}

}  // namespace

double sliding_share(const VectorXd& time, const VectorXd& q, double speed) {
  const Ramp all{0, 0, q.size()};
  double rows = 0.0;
  for (Eigen::Index k = 0; k < q.size(); ++k) rows += is_sliding_at(time, q, all, k, speed) ? 1.0 : 0.0;
  return rows / static_cast<double>(std::max<Eigen::Index>(1, q.size()));
}

double effort_at(const VectorXd& time, const VectorXd& tau, Eigen::Index k) {
  const Window w = window_around(time, k, 0, tau.size());
  return tau.segment(w.from, w.to - w.from + 1).mean();
}

RampThresholds ramp_thresholds(const Coordinate& joint) {
  return joint.prismatic ? RampThresholds{1e-3, 5e-3, 0.5} : RampThresholds{1e-2, 5e-2, 0.5};
}

std::vector<Ramp> find_ramps(const Coordinate& joint, const VectorXd& time, const VectorXd& q,
                             const VectorXd& tau, const RampThresholds& limit) {
  std::vector<Ramp> ramps;
  const Eigen::Index rows = q.size();
  const auto jumps = [&](Eigen::Index k) {
    return std::abs(q[k] - q[k - 1]) > kJumpShare * limit.way;
  };
  Eigen::Index start = 0;
  for (Eigen::Index k = 1; k < rows; ++k) {
    const double off = std::abs(q[k] - q[start]);
    const bool rested = time[k] - time[start] >= limit.rest;
    if (jumps(k) || (!rested && off > kStillShare * limit.way)) {
      start = k;
      continue;
    }
    if (off <= limit.way) continue;
    Ramp ramp{start, k, k + 1};
    while (ramp.end < rows && !jumps(ramp.end)) ++ramp.end;
    ramp.onset = onset_of(time, q, ramp, k, limit.speed);
    if (ramp.onset < ramp.end) ramp.rest = row_after_last_leap(time, tau, ramp);
    if (is_ramp(joint, time, q, tau, ramp, limit)) ramps.push_back(ramp);
    start = k;
  }
  return ramps;
}

}  // namespace veridyn
