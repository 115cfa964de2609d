#include "dvrk/run/controllers/joint_pid.hpp"

#include <algorithm>

#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {

JointPid::JointPid(const PidGains& gains, const VectorXd& integral_limit)
    : gains_(gains), limit_(integral_limit), integral_(VectorXd::Zero(gains.p.size())) {
  const auto n = gains.p.size();
  require(n > 0 && gains.i.size() == n && gains.d.size() == n && limit_.size() == n,
          "joint PID: found gains of ", n, ", ", gains.i.size(), ", ", gains.d.size(),
          " and limits of ", limit_.size(), " joints, expected the same number of each.");
  for (const VectorXd* one : {&gains.p, &gains.i, &gains.d, &integral_limit})
    require(one->allFinite() && one->minCoeff() >= 0.0,
            "joint PID: found a gain or a limit that is negative or NaN.");
}

void JointPid::torques(const VectorXd& q, const VectorXd& dq, const VectorXd& wanted_q,
                       const VectorXd& wanted_dq, double dt, VectorXd& tau) noexcept {
  for (Eigen::Index k = 0; k < tau.size(); ++k) {
    const double e = wanted_q[k] - q[k];
    integral_[k] = std::clamp(integral_[k] + gains_.i[k] * e * dt, -limit_[k], limit_[k]);
    tau[k] = gains_.p[k] * e + integral_[k] + gains_.d[k] * (wanted_dq[k] - dq[k]);
  }
}

}  // namespace veridyn::dvrk
