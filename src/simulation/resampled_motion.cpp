#include "veridyn/simulation/resampled_motion.hpp"

#include <algorithm>
#include <cmath>

#include "math/most_rows.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

// Position, velocity and acceleration at a share u of the interval between two rows, on the quintic
// through all three.
struct Point {
  double q, dq, ddq;
};

// The quintic through two points with their derivatives, h [s] apart, at the share u of that time.
Point quintic(const Point& p0, const Point& p1, double h, double u) {
  // The quintic in x = u is f = c0 + c1 u + ... + c5 u^5, with derivatives scaled by h.
  const double v0 = h * p0.dq;
  const double v1 = h * p1.dq;
  const double a0 = h * h * p0.ddq;
  const double a1 = h * h * p1.ddq;
  const double rise = p1.q - p0.q - v0 - 0.5 * a0;
  const double slope = v1 - v0 - a0;
  const double bend = a1 - a0;
  const double c3 = 10.0 * rise - 4.0 * slope + 0.5 * bend;
  const double c4 = -15.0 * rise + 7.0 * slope - bend;
  const double c5 = 6.0 * rise - 3.0 * slope + 0.5 * bend;
  return {p0.q + u * (v0 + u * (0.5 * a0 + u * (c3 + u * (c4 + u * c5)))),
          (v0 + u * (a0 + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5)))) / h,
          (a0 + u * (6.0 * c3 + u * (12.0 * c4 + u * 20.0 * c5))) / (h * h)};
}

}  // namespace

MotionSamples motion_at(const MotionSamples& m, const VectorRef& times) {
  const Eigen::Index n = m.joints();
  const Eigen::Index rows = times.size();
  MotionSamples out{times, MatrixXd(rows, n), MatrixXd(rows, n), MatrixXd(rows, n)};
  Eigen::Index k = 0;
  for (Eigen::Index row = 0; row < rows; ++row) {
    while (k + 1 < m.rows() && m.time[k + 1] <= times[row]) ++k;
    const Eigen::Index next = std::min(k + 1, m.rows() - 1);
    const double h = m.time[next] - m.time[k];
    const double u = next > k ? std::clamp((times[row] - m.time[k]) / h, 0.0, 1.0) : 0.0;
    for (Eigen::Index i = 0; i < n; ++i) {
      const Point from{m.q(k, i), m.dq(k, i), m.ddq(k, i)};
      const Point to{m.q(next, i), m.dq(next, i), m.ddq(next, i)};
      const Point p = u == 0.0 ? from : u == 1.0 ? to : quintic(from, to, h, u);
      out.q(row, i) = p.q;
      out.dq(row, i) = p.dq;
      out.ddq(row, i) = p.ddq;
    }
  }
  return out;
}

MotionSamples resampled(const MotionSamples& motion, double rate) {
  const double length = motion.time[motion.rows() - 1] - motion.time[0];
  // The memory of wanted, actual and measured positions, velocities, accelerations and torques bounds the
  // number of rows.
  const double most = std::floor(most_rows(12.0 * static_cast<double>(motion.joints())));
  require(length * rate >= 1.0 && length * rate < most, "simulation: found a sample rate of ", rate,
          " Hz for ", length, " s, expected one that makes two rows at least and fewer than ", most,
          " rows, what this machine holds.");
  const auto rows = static_cast<Eigen::Index>(std::floor(length * rate * (1.0 + 1e-12) + 1e-9)) + 1;
  VectorXd times(rows);
  for (Eigen::Index k = 0; k < rows; ++k) times[k] = motion.time[0] + static_cast<double>(k) / rate;
  return motion_at(motion, times);
}

}  // namespace veridyn
