#include "hide_and_seek/motion.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace veridyn::seek {
namespace {

constexpr int kHarmonics = 5;
constexpr int kDeviations = 8;
constexpr double kFade = 1.0;  // [s] in which the deviation comes and goes

struct Value {
  double x = 0.0, dx = 0.0, ddx = 0.0;
};

template <typename Waves>
Value sum(const Waves& waves, double t) {
  Value v;
  for (const auto& w : waves) {
    const double s = std::sin(w.omega * t);
    const double c = std::cos(w.omega * t);
    v.x += w.sine * s + w.cosine * c;
    v.dx += w.omega * (w.sine * c - w.cosine * s);
    v.ddx -= w.omega * w.omega * (w.sine * s + w.cosine * c);
  }
  return v;
}

// 0 at both ends and 1 between: 35 u^4 - 84 u^5 + 70 u^6 - 20 u^7, smooth to its third derivative.
Value fade(double t, double duration) {
  const double direction = t < duration - t ? 1.0 : -1.0;
  const double u = std::max(0.0, std::min(t, duration - t)) / kFade;
  if (u >= 1.0) return {1.0, 0.0, 0.0};
  const double v = 1.0 - u;
  return {u * u * u * u * (35.0 - 84.0 * u + 70.0 * u * u - 20.0 * u * u * u),
          direction * 140.0 * u * u * u * v * v * v / kFade,
          420.0 * u * u * v * v * (1.0 - 2.0 * u) / (kFade * kFade)};
}

}  // namespace

Motion::Motion(const Model& arm, unsigned seed, int number, double reach) {
  Draw draw(seed, "motion " + arm.name() + " " + std::to_string(number));
  const double frequency = draw.in(0.075, 0.1);  // [Hz]: 20 to 27 s for two periods
  duration_ = 2.0 / frequency;
  const double w = 2.0 * M_PI * frequency;
  for (const Coordinate& c : arm.coordinates()) {
    Joint joint;
    // dq = sum a_k cos(k w t) + b_k sin(k w t) with sum a_k = 0 and sum k b_k = 0: at rest, without
    // a jump of the acceleration, at both ends.
    VectorXd a(kHarmonics);
    VectorXd b(kHarmonics);
    const VectorXd k = VectorXd::LinSpaced(kHarmonics, 1.0, kHarmonics);
    for (int h = 0; h < kHarmonics; ++h) {
      a[h] = draw.normal();
      b[h] = draw.normal();
    }
    a.array() -= a.mean();
    b -= k * (k.dot(b) / k.squaredNorm());
    for (int h = 0; h < kHarmonics; ++h) {
      const double omega = w * k[h];
      joint.wanted.push_back({omega, a[h] / omega, -b[h] / omega});
    }
    double low = INFINITY;
    double high = -INFINITY;
    double speed = 0.0;
    for (int i = 0; i <= 400; ++i) {
      const Value v = sum(joint.wanted, i / 400.0 / frequency);
      low = std::min(low, v.x);
      high = std::max(high, v.x);
      speed = std::max(speed, std::abs(v.dx));
    }
    const double range = c.limits.upper - c.limits.lower;
    const double by_speed = draw.in(0.65, 0.9) * c.limits.velocity / speed;
    const double by_range = draw.in(0.6, 0.85) * range / (high - low);
    const double scale = reach * std::min(by_range, by_speed);
    for (Wave& wave : joint.wanted) {
      wave.sine *= scale;
      wave.cosine *= scale;
    }
    const double margin = 0.5 * (0.9 * range - scale * (high - low));
    joint.centre = 0.5 * (c.limits.lower + c.limits.upper) - 0.5 * scale * (high + low) +
                   draw.in(-margin, margin);
    add_deviation(joint, c.prismatic, draw);
    joints_.push_back(std::move(joint));
  }
}

Motion::Motion(const Model& arm, Rows wanted, unsigned seed, int number)
    : given_(std::move(wanted)), duration_(given_.time[given_.time.size() - 1]) {
  Draw draw(seed, "deviation " + arm.name() + " " + std::to_string(number));
  for (const Coordinate& c : arm.coordinates()) {
    Joint joint;
    add_deviation(joint, c.prismatic, draw);
    joints_.push_back(std::move(joint));
  }
}

void Motion::add_deviation(Joint& joint, bool prismatic, Draw& draw) const {
  const double deviation = (prismatic ? 5e-4 : 3e-3) * draw.in(0.5, 1.5);
  for (int h = 0; h < kDeviations; ++h) {
    const double size = deviation * std::sqrt(2.0 / kDeviations);
    const double phase = draw.in(0.0, 2.0 * M_PI);
    joint.deviation.push_back(
        {2.0 * M_PI * draw.in(0.05, 0.6), size * std::cos(phase), size * std::sin(phase)});
  }
}

namespace {

// The polynomial of fifth order between two rows that has their values and derivatives.
Value between(const Motion::Rows& rows, Eigen::Index joint, double t) {
  const double h = rows.time[1] - rows.time[0];
  const auto k = std::clamp<Eigen::Index>(static_cast<Eigen::Index>(t / h), 0, rows.q.rows() - 2);
  const double u = std::clamp((t - rows.time[k]) / h, 0.0, 1.0);
  const double v = rows.dq(k, joint) * h;
  const double a = rows.ddq(k, joint) * h * h;
  const double D = rows.q(k + 1, joint) - rows.q(k, joint) - v - 0.5 * a;
  const double V = rows.dq(k + 1, joint) * h - v - a;
  const double A = rows.ddq(k + 1, joint) * h * h - a;
  const double c3 = 10.0 * D - 4.0 * V + 0.5 * A;
  const double c4 = -15.0 * D + 7.0 * V - A;
  const double c5 = 6.0 * D - 3.0 * V + 0.5 * A;
  return {rows.q(k, joint) + u * (v + u * (0.5 * a + u * (c3 + u * (c4 + u * c5)))),
          (v + u * (a + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5)))) / h,
          (a + u * (6.0 * c3 + u * (12.0 * c4 + u * 20.0 * c5))) / (h * h)};
}

}  // namespace

State Motion::at(double t) const {
  const auto n = static_cast<Eigen::Index>(joints_.size());
  State s{VectorXd(n), VectorXd(n), VectorXd(n)};
  const Value f = fade(t, duration_);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Joint& joint = joints_[i];
    const Value v = given_.time.size() > 0 ? between(given_, i, t) : sum(joint.wanted, t);
    const Value e = sum(joint.deviation, t);
    s.q[i] = joint.centre + v.x + f.x * e.x;
    s.dq[i] = v.dx + f.x * e.dx + f.dx * e.x;
    s.ddq[i] = v.ddx + f.x * e.ddx + 2.0 * f.dx * e.dx + f.ddx * e.x;
  }
  return s;
}

Motion::Rows Motion::sampled(double rate) const {
  const auto rows = static_cast<Eigen::Index>(duration_ * rate) + 1;
  const auto n = static_cast<Eigen::Index>(joints_.size());
  Rows out{VectorXd(rows), MatrixXd(rows, n), MatrixXd(rows, n), MatrixXd(rows, n)};
  for (Eigen::Index r = 0; r < rows; ++r) {
    out.time[r] = static_cast<double>(r) / rate;
    const State s = at(out.time[r]);
    out.q.row(r) = s.q;
    out.dq.row(r) = s.dq;
    out.ddq.row(r) = s.ddq;
  }
  return out;
}

}  // namespace veridyn::seek
