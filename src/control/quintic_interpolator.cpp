#include "veridyn/control/quintic_interpolator.hpp"

#include <algorithm>
#include <cmath>

#include "veridyn/math/require.hpp"

namespace veridyn {

QuinticInterpolator::QuinticInterpolator(const VectorRef& x)
    : x_(x), dx_(VectorXd::Zero(x.size())), ddx_(dx_), goal_(x), c_(MatrixXd::Zero(x.size(), 6)) {
  require(x.size() > 0 && x.allFinite(), "QuinticInterpolator: found a start of ", x.size(),
          " entries, expected at least one, and all of them finite.");
}

void QuinticInterpolator::reset(const VectorRef& x) noexcept {
  if (x.size() != x_.size() || !x.allFinite()) return;
  x_ = goal_ = x;
  dx_.setZero();
  ddx_.setZero();
  time_ = duration_ = 0.0;
}

bool QuinticInterpolator::move_to(const VectorRef& goal, double duration) noexcept {
  if (goal.size() != x_.size() || !goal.allFinite() || !(duration > 0.0) ||
      !std::isfinite(duration))
    return false;
  goal_ = goal;
  duration_ = duration;
  time_ = 0.0;
  const double T = duration;
  for (Eigen::Index i = 0; i < x_.size(); ++i) {
    const double far = goal_[i] - x_[i] - dx_[i] * T - 0.5 * ddx_[i] * T * T;
    const double fast = (-dx_[i] - ddx_[i] * T) * T;
    const double bent = -ddx_[i] * T * T;
    c_(i, 0) = x_[i];
    c_(i, 1) = dx_[i];
    c_(i, 2) = 0.5 * ddx_[i];
    c_(i, 3) = (10.0 * far - 4.0 * fast + 0.5 * bent) / (T * T * T);
    c_(i, 4) = (-15.0 * far + 7.0 * fast - bent) / (T * T * T * T);
    c_(i, 5) = (6.0 * far - 3.0 * fast + 0.5 * bent) / (T * T * T * T * T);
  }
  return true;
}

bool QuinticInterpolator::stop(double duration) noexcept {
  if (!(duration > 0.0) || !std::isfinite(duration)) return false;
  goal_ = x_ + 0.5 * duration * dx_;
  return move_to(goal_, duration);
}

void QuinticInterpolator::advance(double dt) noexcept {
  if (!(dt >= 0.0) || arrived()) return;
  time_ += dt;
  // The motion ends in the cycle in which the sum of the time steps reaches the duration, except for rounding.
  if (time_ >= duration_ * (1.0 - 1e-9)) {
    time_ = duration_;
    x_ = goal_;
    dx_.setZero();
    ddx_.setZero();
    return;
  }
  const double t = time_;
  for (Eigen::Index i = 0; i < x_.size(); ++i) {
    const auto c = [&](int k) { return c_(i, k); };
    x_[i] = c(0) + t * (c(1) + t * (c(2) + t * (c(3) + t * (c(4) + t * c(5)))));
    dx_[i] = c(1) + t * (2.0 * c(2) + t * (3.0 * c(3) + t * (4.0 * c(4) + t * 5.0 * c(5))));
    ddx_[i] = 2.0 * c(2) + t * (6.0 * c(3) + t * (12.0 * c(4) + t * 20.0 * c(5)));
  }
}

double QuinticInterpolator::duration_for(double distance, double velocity,
                                         double acceleration) noexcept {
  // The peak speed of a quintic is 15/8 of its mean speed; the peak acceleration is 10/sqrt(3) times distance
  // over squared time.
  const double way = std::abs(distance);
  return std::max(1.875 * way / velocity, std::sqrt(10.0 / std::sqrt(3.0) * way / acceleration));
}

}  // namespace veridyn
