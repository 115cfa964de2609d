#include "veridyn/control/joint_pid.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "veridyn/math/require.hpp"

namespace veridyn {

JointPid::JointPid(const PidGains& gains, const PidLimits& limits)
    : gains_(gains), limits_(limits), integral_(VectorXd::Zero(gains.p.size())) {
  const auto n = gains.p.size();
  for (VectorXd* one : {&limits_.integral, &limits_.torque}) {
    if (one->size() == 0) one->setConstant(n, std::numeric_limits<double>::infinity());
    require(one->size() == n && (one->array() >= 0.0).all(), "joint PID: found limits that are not ", n,
            " numbers, none below zero.");
  }
  for (const VectorXd* one : {&gains.p, &gains.i, &gains.d})
    require(n > 0 && one->size() == n && one->allFinite() && one->minCoeff() >= 0.0,
            "joint PID: found gains that are not ", n, " finite numbers, none below zero.");
}

void JointPid::torques(const VectorRef& q, const VectorRef& dq, const VectorRef& wanted_q,
                       const VectorRef& wanted_dq, double dt, VectorXd& tau) noexcept {
  assert(tau.size() == integral_.size());
  for (Eigen::Index k = 0; k < tau.size(); ++k) {
    const double e = wanted_q[k] - q[k];
    const double most = limits_.integral[k];
    const double integral = std::clamp(integral_[k] + dt * gains_.i[k] * e, -most, most);
    tau[k] = gains_.p[k] * e + integral + gains_.d[k] * (wanted_dq[k] - dq[k]);
    if (std::abs(tau[k]) <= limits_.torque[k] && std::isfinite(integral)) integral_[k] = integral;
  }
}

}  // namespace veridyn
