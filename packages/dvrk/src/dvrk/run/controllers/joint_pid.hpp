#pragma once

#include "veridyn/math/types.hpp"
#include "veridyn/simulation/control_loop.hpp"

namespace veridyn::dvrk {

/// tau = p e + i (integral of e) + d de, per joint. The integral is held within `integral_limit` of
/// torque. Nothing is allocated after the constructor.
class JointPid {
 public:
  /// @param integral_limit  (n) [N m], [N] largest output of the integral. @throws InvalidInput
  /// vectors of different sizes, or gains that are negative or NaN.
  JointPid(const PidGains& gains, const VectorXd& integral_limit);

  /// All (n), stored vectors. @param dt  [s] since the previous call.
  void torques(const VectorXd& q, const VectorXd& dq, const VectorXd& wanted_q,
               const VectorXd& wanted_dq, double dt, VectorXd& tau) noexcept;
  void reset() noexcept { integral_.setZero(); }

 private:
  PidGains gains_;
  VectorXd limit_;
  VectorXd integral_;  ///< as torque
};

}  // namespace veridyn::dvrk
