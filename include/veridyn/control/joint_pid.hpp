#pragma once

#include "veridyn/math/types.hpp"

namespace veridyn {

/// Gains of tau = p e + i (integral of e) + d de/dt for each joint, with e the wanted minus the measured
/// position, (n) each: [N m/rad], [N m/(rad s)], [N m s/rad]; newtons and metres where a joint is prismatic.
struct PidGains {
  VectorXd p, i, d;
};

/// Bounds of JointPid, (n) each [N m], [N]; empty: none.
struct PidLimits {
  VectorXd integral;  ///< largest output of the integral
  VectorXd torque;    ///< torque limit; the integral stops while it is exceeded (anti-windup)
};

/// PID of each joint on its own, without a model. Nothing allocates after the constructor.
class JointPid {
 public:
  /// @throws InvalidInput  vectors of different sizes, a gain that is negative or not finite, a limit
  /// that is negative or NaN.
  JointPid(const PidGains& gains, const PidLimits& limits = {});

  /// Computes tau (n). All vectors are stored ones of n entries. @param dt  [s] since the previous call.
  void torques(const VectorRef& q, const VectorRef& dq, const VectorRef& wanted_q,
               const VectorRef& wanted_dq, double dt, VectorXd& tau) noexcept;
  void reset() noexcept { integral_.setZero(); }

 private:
  PidGains gains_;
  PidLimits limits_;
  VectorXd integral_;  ///< integral terms [N m], [N]
};

}  // namespace veridyn
