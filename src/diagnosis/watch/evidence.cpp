#include "diagnosis/watch/evidence.hpp"

#include <algorithm>
#include <cmath>

#include "identification/estimation/least_squares.hpp"
#include "math/numbers.hpp"
#include "math/student_t.hpp"

namespace veridyn::watching {
namespace {

constexpr double kHour = 3600.0;       // [s]

}  // namespace

void Memory::add(const WhiteStep& step) {
  A *= forgetting;
  b *= forgetting;
  A += step.X.colwise().squaredNorm().transpose();
  b += step.X.transpose() * step.e;
}

namespace {

// The best admissible size, and its gain.
double bounded_size(double A, double b, double least, double largest) {
  return A > kNothing ? std::clamp(b / A, least, largest) : 0.0;
}
// Gain of a size: twice the log-likelihood ratio to zero, for information A and weighted residual b.
double gain(double A, double b, double size) {
  return size * (2.0 * b - A * size);
}

}  // namespace

VectorXd Memory::statistics(const VectorXd& least, const VectorXd& largest) const {
  VectorXd out(A.size());
  for (Eigen::Index h = 0; h < A.size(); ++h)
    out[h] = gain(A[h], b[h], bounded_size(A[h], b[h], least[h], largest[h]));
  return out;
}

Quantiles::Quantiles(int hypotheses, int memories, const WatchNumbers& numbers)
    : numbers_(numbers), threshold_(static_cast<size_t>(memories), VectorXd::Constant(hypotheses, kInfinity)) {}

void Quantiles::learn(const MatrixXd& mean, const std::vector<Memory>& memories,
                      double quiet_seconds, double false_alarms_per_hour) {
  const double tests = static_cast<double>(mean.size());
  for (size_t m = 0; m < memories.size(); ++m) {
    const double windows = quiet_seconds / memories[m].seconds;
    VectorXd& threshold = threshold_[m];
    threshold.setConstant(kInfinity);
    if (windows < 1.0) continue;
    const double freedom = numbers_.prior_freedom + windows;
    // Fitted to a quiet time, the statistic is too small there by 1 - 1/windows, and too large
    // afterwards by 1 + 1/windows.
    const double fitted = std::pow(1.0 + 1.0 / windows, 2);
    const double probability = false_alarms_per_hour * memories[m].seconds / (kHour * tests);
    const double quantile = std::pow(student_t_quantile(probability, freedom), 2);
    double all = 0.0;
    for (Eigen::Index h = 0; h < mean.rows(); ++h) {
      const double seen = mean(h, static_cast<Eigen::Index>(m));
      const double dispersion =
          (numbers_.prior_freedom * numbers_.prior_dispersion + windows * seen * fitted) / freedom;
      threshold[h] = dispersion * quantile;
      all += dispersion / static_cast<double>(mean.rows());
    }
    if (m <= memories.size() / 2) {
      dispersion_ = all;
      freedom_ = freedom;
    }
  }
}

Score best_onset(const std::deque<WhiteStep>& steps, int hypothesis, double least, double largest,
                 double earliest, double latest) {
  Score best;
  best.hypothesis = hypothesis;
  best.columns = {hypothesis};
  double A = 0.0;
  double b = 0.0;
  for (auto step = steps.rbegin(); step != steps.rend() && step->time >= earliest; ++step) {
    A += step->X.col(hypothesis).squaredNorm();
    b += step->X.col(hypothesis).dot(step->e);
    const double size = bounded_size(A, b, least, largest);
    if (step->time > latest || gain(A, b, size) <= best.gain) continue;
    best.gain = gain(A, b, size);
    best.onset = step->time;
    best.A = MatrixXd::Constant(1, 1, A);
    best.size = VectorXd::Constant(1, size);
  }
  return best;
}

double Score::deviation() const {
  if (A.rows() == 0) return kInfinity;
  return std::sqrt(std::max(0.0, normal_solution(A, VectorXd::Unit(A.rows(), 0))[0]));
}

namespace {

// Least squares of the score's columns from a time on; steps before it may be of another day, with later times. @returns the gain.
double solve_from(const std::deque<WhiteStep>& steps, double from, double mass, const WatchNumbers& numbers, Score& score) {
  const auto count = static_cast<Eigen::Index>(score.columns.size());
  score.A = MatrixXd::Zero(count, count);
  VectorXd b = VectorXd::Zero(count);
  for (auto step = steps.rbegin(); step != steps.rend() && step->time >= from; ++step) {
    const MatrixXd X = step->X(Eigen::all, score.columns);
    score.A += X.transpose() * X;
    b += X.transpose() * step->e;
  }
  const double lever = std::max(numbers.lever * std::abs(mass), kNothing);
  score.A.diagonal().tail(count - 1).array() += 1.0 / (lever * lever);
  if (!(score.A(0, 0) > kNothing)) return 0.0;
  score.size = normal_solution(score.A, b);
  return b.dot(score.size);
}

}  // namespace

Score reestimated(const std::deque<WhiteStep>& steps, const Score& score, double skipped,
                     const WatchNumbers& numbers) {
  if (score.size.size() == 0) return score;
  Score out = score;
  const bool some = solve_from(steps, score.onset + skipped, score.size[0], numbers, out) > 0.0;
  return some && std::abs(out.size[0]) < 2.0 * std::abs(score.size[0]) ? out : score;
}

Score with_companions(const std::deque<WhiteStep>& steps, const Score& alone,
                      const std::vector<int>& companions, double price, const WatchNumbers& numbers) {
  if (companions.empty() || alone.size.size() == 0) return alone;
  Score out = alone;
  out.columns.insert(out.columns.end(), companions.begin(), companions.end());
  const auto count = static_cast<Eigen::Index>(out.columns.size());
  out.gain = solve_from(steps, alone.onset, alone.size[0], numbers, out) - price * static_cast<double>(count - 1);
  const bool known = std::abs(out.size[0]) > 2.0 * out.deviation();
  return known && out.gain > alone.gain ? out : alone;
}

Push best_push(const std::deque<WhiteStep>& steps, const std::vector<int>& offset_of_joint,
               double earliest, double latest, double still, double price,
               const WatchNumbers& numbers) {
  const size_t n = offset_of_joint.size();
  Push best;
  if (steps.empty()) return best;
  const double end = steps.back().time - still;
  for (size_t o = 0; o < steps.size(); ++o) {
    if (steps[o].time < earliest || steps[o].time > latest) continue;
    double settled = 0.0;  // of completed segments
    VectorXd A = VectorXd::Zero(n), b = A, all_A = A, all_b = A;
    double segment = steps[o].time;
    for (size_t k = o; k < steps.size() && steps[k].time <= end; ++k) {
      double open = 0.0;
      for (size_t j = 0; j < n; ++j) {
        const auto i = static_cast<Eigen::Index>(j);
        const double x = steps[k].X(i, offset_of_joint[j]);
        A[i] += x * x;
        b[i] += x * steps[k].e[i];
        all_A[i] += x * x;
        all_b[i] += x * steps[k].e[i];
        if (A[i] > kNothing) open += std::max(0.0, b[i] * b[i] / A[i] - price);
      }
      const bool whole = steps[k].time - segment >= numbers.short_memory;
      const bool last = k + 1 == steps.size() || steps[k + 1].time > end;
      // A push that has not ended extends to the last step.
      if (steps[k].time - steps[o].time >= numbers.shortest_push && settled + open > best.gain &&
          (still > 0.0 || last)) {
        best.gain = settled + open;
        best.from = steps[o].time;
        best.to = steps[k].time;
        best.torque = all_b.cwiseQuotient(all_A.cwiseMax(kNothing));
        best.last_joint.reset();
        const VectorXd share = all_b.cwiseAbs2().cwiseQuotient(all_A.cwiseMax(kNothing));
        for (size_t j = 0; j < n; ++j)
          if (share[static_cast<Eigen::Index>(j)] > std::max(price, numbers.active * share.maxCoeff()))
            best.last_joint = JointIndex{static_cast<int>(j)};
      }
      if (!whole) continue;
      if (settled + open <= 0.0) break;  // no gain so far: a later onset is equivalent
      settled += open;
      A.setZero();
      b.setZero();
      segment = steps[k].time;
    }
  }
  return best;
}

}  // namespace veridyn::watching
