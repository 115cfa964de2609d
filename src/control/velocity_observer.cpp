#include "veridyn/control/velocity_observer.hpp"

#include <cassert>
#include <cmath>

#include "veridyn/math/require.hpp"

namespace veridyn {

VelocityObserver::VelocityObserver(int joints, double bandwidth)
    : bandwidth_(bandwidth), q_(VectorXd::Zero(joints)), dq_(q_) {
  require(bandwidth > 0.0 && std::isfinite(bandwidth), "VelocityObserver: found a bandwidth of ",
          bandwidth, " 1/s, expected one above zero.");
}

void VelocityObserver::reset() noexcept {
  first_ = true;
  dq_.setZero();
}

const VectorXd& VelocityObserver::update(const VectorRef& q, const VectorRef& ddq,
                                         double dt) noexcept {
  assert(q.size() == q_.size() && ddq.size() == q_.size());
  if (first_ && q.allFinite()) {
    q_ = q;
    first_ = false;
    return dq_;
  }
  if (first_ || !(dt > 0.0) || !std::isfinite(dt)) return dq_;
  const double p = std::exp(-bandwidth_ * dt);
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const double a = std::isfinite(ddq[i]) ? ddq[i] : 0.0;
    q_[i] += dq_[i] * dt + 0.5 * a * dt * dt;
    dq_[i] += a * dt;
    if (!std::isfinite(q[i])) continue;
    const double e = q[i] - q_[i];
    q_[i] += (1.0 - p * p) * e;
    dq_[i] += (1.0 - p) * (1.0 - p) * e / dt;
  }
  return dq_;
}

}  // namespace veridyn
