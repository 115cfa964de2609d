#include "recordings/steady_runs.hpp"

#include <algorithm>
#include <cmath>

namespace veridyn {
namespace {

constexpr double kBand = 0.1;          // relative deviation from the mean speed, to either side
constexpr double kShortest = 0.5;      // [s] shortest run
constexpr double kRestShare = 0.01;    // share of the largest speed, below which the joint is at rest
constexpr double kGapSteps = 3.0;      // sampling steps between two samples that form a gap
constexpr double kTravelTurn = 2e-2;   // [rad] smallest travel of a revolute joint
constexpr double kTravelSlide = 2e-3;  // [m] smallest travel of a prismatic joint

}  // namespace

std::vector<SteadyRun> steady_runs(const std::vector<double>& time, const std::vector<double>& dq) {
  std::vector<SteadyRun> runs;
  if (time.size() < 2) return runs;
  double largest = 0.0;
  for (const double v : dq) largest = std::max(largest, std::abs(v));
  const double gap = kGapSteps * (time.back() - time.front()) / static_cast<double>(time.size() - 1);
  for (std::size_t k = 0; k < time.size();) {
    double low = dq[k], high = dq[k], sum = 0.0;
    std::size_t end = k;
    while (end < time.size() && (end == k || time[end] - time[end - 1] < gap)) {
      const double least = std::min(low, dq[end]), most = std::max(high, dq[end]);
      const double slowest = std::min(std::abs(least), std::abs(most));
      if (least * most <= 0.0 || slowest <= kRestShare * largest) break;
      const double mean = (sum + dq[end]) / static_cast<double>(end - k + 1);
      if (std::max(most - mean, mean - least) > kBand * std::abs(mean)) break;
      low = least;
      high = most;
      sum += dq[end++];
    }
    if (end > k && time[end - 1] - time[k] >= kShortest) {
      runs.push_back({k, end, sum / static_cast<double>(end - k)});
      k = end;
    } else {
      ++k;
    }
  }
  return runs;
}

bool same_speed(double a, double b) {
  return std::abs(a - b) <= kBand * std::max(std::abs(a), std::abs(b));
}

bool travels_far_enough(double from, double to, bool prismatic) {
  return to - from >= (prismatic ? kTravelSlide : kTravelTurn);
}

double rounded_hold_position(double position, bool prismatic) {
  const double step = 0.5 * (prismatic ? kTravelSlide : kTravelTurn);
  return step * std::round(position / step);
}

}  // namespace veridyn
