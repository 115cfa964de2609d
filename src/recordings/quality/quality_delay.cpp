// Estimates the delay of recorded velocities.
#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/LU>

#include "recordings/quality/quality_checks.hpp"

namespace veridyn::quality {
namespace {

// Derivative of q, and dq, both averaged symmetrically over 8 rows, which adds no delay. Both are NaN near a
// missing or wrong row.
struct Velocities {
  double step = 0.0;  // [s] mean time step
  VectorXd from_q;
  VectorXd recorded;
};

Velocities smoothed_velocities(const Head& head, int joint) {
  const Recording& rows = head.rows;
  const int half = numbers.half_average;
  const int count = std::min(rows.rows(), kLagRows);
  Velocities v{(rows.time[count - 1] - rows.time[0]) / (count - 1),
               VectorXd::Constant(count, kNone), VectorXd::Constant(count, kNone)};
  VectorXd steps = VectorXd::Zero(count);
  steps.tail(count - 1) =
      (rows.q.col(joint).segment(1, count - 1) - rows.q.col(joint).head(count - 1)).cwiseAbs();
  const double longest = numbers.large_step * quantile({steps.data(), steps.data() + count}, 1.0 - numbers.ends);
  int broken = 0;  // last row that must not be included
  for (int last = 1; last < count; ++last) {
    const bool hole = rows.time[last] - rows.time[last - 1] > numbers.hole * head.step;
    if (hole || !(steps[last] <= longest) || std::isnan(rows.dq(last, joint))) broken = last;
    const int first = last - 2 * half;
    if (first < broken) continue;
    const auto dq = rows.dq.col(joint).segment(first, 2 * half + 1);
    v.from_q[last - half] =
        (rows.q(last, joint) - rows.q(first, joint)) / (rows.time[last] - rows.time[first]);
    v.recorded[last - half] = (dq.sum() - 0.5 * (dq[0] + dq[2 * half])) / (2 * half);
  }
  return v;
}

// Delay of the recorded velocity in whole rows: the peak of the correlation.
std::optional<int> whole_delay(const Velocities& v) {
  const int longest = numbers.longest_lag;
  const int core = static_cast<int>(v.from_q.size()) - 2 * longest;
  if (core < 4 * longest) return std::nullopt;
  const VectorXd from_q = v.from_q.array().isNaN().select(0.0, v.from_q);
  const VectorXd recorded = v.recorded.array().isNaN().select(0.0, v.recorded);
  const auto q = from_q.segment(longest, core);
  const double size = q.norm();
  double peak = 0.0;
  int best = 0;
  double squares = recorded.head(core).squaredNorm();  // sum of squares over the compared rows
  for (int lag = -longest; lag <= longest; ++lag) {
    const int first = longest + lag;
    const double correlation = std::abs(q.dot(recorded.segment(first, core))) /
                               std::max(size * std::sqrt(std::max(squares, 0.0)), 1e-300);
    if (lag < longest) squares += std::pow(recorded[first + core], 2) - std::pow(recorded[first], 2);
    if (correlation <= peak) continue;
    peak = correlation;
    best = lag;
  }
  if (peak < numbers.clear_peak || std::abs(best) == longest) return std::nullopt;
  return best;
}

}  // namespace

// Delay of dq behind the derivative v of q [s], if significant. Its fraction of a row follows from
//   dq(t) = f v(t - delay) = f v(t) - f delay dv/dt
// by least squares, repeated without outliers.
std::optional<double> velocity_delay(const Head& head, int joint) {
  constexpr int kReach = 2;  // number of rows on either side that a derivative uses
  const Velocities v = smoothed_velocities(head, joint);
  const std::optional<int> whole = whole_delay(v);
  if (!whole) return std::nullopt;
  const int margin = numbers.longest_lag + kReach;
  const int rows = static_cast<int>(v.from_q.size()) - 2 * margin;
  Eigen::MatrixX2d A(rows, 2);  // columns v, -dv/dt
  A.col(0) = v.from_q.segment(margin, rows);
  A.col(1) =
      (v.from_q.segment(margin - kReach, rows) - v.from_q.segment(margin + kReach, rows)) /
      (2.0 * kReach * v.step);
  VectorXd recorded = v.recorded.segment(margin + *whole, rows);
  VectorXd weights = VectorXd::Ones(rows);
  for (int k = 0; k < rows; ++k) {
    if (std::isfinite(A.row(k).sum() + recorded[k])) continue;
    A.row(k).setZero();
    weights[k] = recorded[k] = 0.0;
  }
  const VectorXd known = weights;
  Eigen::Vector2d fit;  // solution f, f * delay
  for (int pass = 0; pass < 2; ++pass) {
    const Eigen::Matrix2d square = A.transpose() * weights.asDiagonal() * A;
    if (!(square.determinant() > kSingular * square(0, 0) * square(1, 1))) return std::nullopt;
    fit = square.inverse() * (A.transpose() * weights.cwiseProduct(recorded));
    const VectorXd errors = (recorded - A * fit).cwiseAbs();
    const VectorXd judged = (known.array() > 0.0).select(errors, kNone);
    const double allowed = numbers.lag_outlier * quantile({judged.data(), judged.data() + rows}, 0.5);
    weights = known.array() * (errors.array() <= allowed).cast<double>();
  }
  return *whole * v.step + fit[1] / fit[0];
}

}  // namespace veridyn::quality
