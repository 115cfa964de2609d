#include "slow_passes.hpp"

#include <algorithm>
#include <cmath>

namespace veridyn {
namespace {

constexpr double kSlowest = 0.01;      // slowest pass, as a share of the largest speed
constexpr double kFastest = 0.1;       // fastest pass, as a share of the largest speed
constexpr double kWayOut = 3.0;        // [s] longest duration of the outward motion
constexpr double kShortestWay = 0.3;   // [s] shortest motion at constant speed
constexpr double kShortestRamp = 0.2;  // [s] shortest acceleration from rest
constexpr double kRoom = 0.95;         // share of the available range that is used
constexpr int kHalvings = 6;
// Distance that a reversal overshoots, as a share of its speed times its duration.
constexpr double kOvershoot = 0.3125;

// A part of a pass in which the speed changes between two values along 3 u^2 - 2 u^3.
struct Part {
  double from, to, seconds;
};

struct Point {
  double q = 0.0, dq = 0.0, ddq = 0.0;
};

double distance_of(const Part& p) {
  return 0.5 * (p.from + p.to) * p.seconds;
}

Point point_at(const std::vector<Part>& parts, double t) {
  Point out;
  for (const Part& p : parts) {
    if (t > p.seconds) {
      out.q += distance_of(p);
      t -= p.seconds;
      continue;
    }
    const double u = t / p.seconds;
    const double step = p.to - p.from;
    out.q += p.from * t + step * p.seconds * u * u * u * (1.0 - 0.5 * u);
    out.dq = p.from + step * u * u * (3.0 - 2.0 * u);
    out.ddq = step * 6.0 * u * (1.0 - u) / p.seconds;
    return out;
  }
  return out;
}

// Moves out and back, twice. @param v  speed with the sign of the direction.
std::vector<Part> pass(double v, double hold, double ramp) {
  const double turn = 2.0 * ramp;
  const double back = std::max(kShortestWay, hold - ramp);
  return {{0, v, ramp}, {v, v, hold},  {v, -v, turn},  {-v, -v, back}, {-v, v, turn},
          {v, v, back}, {v, -v, turn}, {-v, -v, hold}, {-v, 0, ramp}};
}

MotionSamples sampled_motion(const std::vector<Part>& parts, const VectorXd& rest, Eigen::Index joint,
                      double rate) {
  double seconds = 0.0;
  for (const Part& p : parts) seconds += p.seconds;
  const auto last = static_cast<Eigen::Index>(std::ceil(seconds * rate));
  const MatrixXd still = MatrixXd::Zero(last + 1, rest.size());
  MotionSamples out{VectorXd::LinSpaced(last + 1, 0.0, static_cast<double>(last) / rate),
                    rest.transpose().replicate(last + 1, 1), still, still};
  for (Eigen::Index k = 0; k <= last; ++k) {
    if (out.time[k] >= seconds) continue;  // the joint rests again
    const Point p = point_at(parts, out.time[k]);
    out.q(k, joint) += p.q;
    out.dq(k, joint) = p.dq;
    out.ddq(k, joint) = p.ddq;
  }
  return out;
}

// The pass at one speed with the largest displacement that fits into `space`, which has the sign of the
// direction; empty if none fits.
std::vector<Part> longest_pass(double speed, double space, double acceleration) {
  const double way = kRoom * std::abs(space);
  // The largest acceleration of a ramp is 1.5 times its speed over its duration.
  const double ramp = std::max(kShortestRamp, 1.5 * speed / acceleration);
  const double extra = 0.5 * ramp + 2.0 * kOvershoot * ramp;
  const double hold = std::min(kWayOut, way / speed - extra);
  if (hold < kShortestWay) return {};
  return pass(space > 0.0 ? speed : -speed, hold, ramp);
}

}  // namespace

MotionSamples slow_passes(const MotionLimits& limits, const VectorXd& rest,
                          const std::vector<int>& joints, int passes, double rate,
                          const std::function<bool(const MotionSamples&)>& keeps) {
  MotionSamples out;
  for (const int i : joints) {
    const double above = limits.upper[i] - rest[i];
    const double below = limits.lower[i] - rest[i];
    for (int k = 0; k < passes; ++k) {
      const double share = passes > 1 ? static_cast<double>(k) / (passes - 1) : 0.5;
      const double speed = limits.velocity[i] * kSlowest * std::pow(kFastest / kSlowest, share);
      double space = above > -below ? above : below;
      for (int halving = 0; halving <= kHalvings; ++halving, space *= 0.5) {
        const std::vector<Part> parts = longest_pass(speed, space, limits.acceleration[i]);
        if (parts.empty()) break;
        const MotionSamples one = sampled_motion(parts, rest, i, rate);
        if (!keeps(one)) continue;
        out = joined(out, one);
        break;
      }
    }
  }
  return out;
}

MotionSamples joined(const MotionSamples& first, const MotionSamples& second) {
  if (first.rows() == 0) return second;
  if (second.rows() == 0) return first;
  const Eigen::Index a = first.rows();
  const Eigen::Index b = second.rows() - 1;
  const Eigen::Index n = first.joints();
  MotionSamples out{VectorXd(a + b), MatrixXd(a + b, n), MatrixXd(a + b, n), MatrixXd(a + b, n)};
  out.time << first.time, (second.time.tail(b).array() + first.time[a - 1]).matrix();
  out.q << first.q, second.q.bottomRows(b);
  out.dq << first.dq, second.dq.bottomRows(b);
  out.ddq << first.ddq, second.ddq.bottomRows(b);
  return out;
}

}  // namespace veridyn
