#pragma once

#include "veridyn/control/arm_state.hpp"
#include "veridyn/math/types.hpp"

namespace veridyn {

/// Where the joints shall be, (n) each.
struct JointReference {
  explicit JointReference(int joints) : q(VectorXd::Zero(joints)), dq(q), ddq(q) {}
  VectorXd q, dq, ddq;
};

/// Diagonals of K_p [1/s^2] and K_d [1/s], (n) each: with them, what is left of a joint's error
/// obeys e'' + K_d e' + K_p e = 0, whatever the joint's inertia.
struct JointGains {
  VectorXd p, d;
};

/// The model as feed-forward and a double integrator to control (thesis 7.1 to 7.5, with the wanted
/// acceleration, which the thesis leaves out):
///
///   y   = ddq_d + K_p (q_d - q) + K_d (dq_d - dq)
///   tau = M(q) y + bias(q, dq)
///
/// Friction and what the model gets wrong are added by FrictionCompensation and ModelErrorObserver:
///
///   state.update(q, dq);
///   tau = control.update(state, wanted);
///   tau += friction.update(state, wanted.dq, error, dt);  // stored vectors
///   tau += model_error.update(state, control.acceleration(), dt);
class ComputedTorque {
 public:
  /// @throws InvalidInput  gains that are not `joints` finite numbers, none below zero.
  ComputedTorque(int joints, const JointGains& gains);

  /// @returns tau (n), valid until the next update().
  /// Sizes are those of the constructor; another one is a fault of the program, asserted in debug
  /// builds alone.
  const VectorXd& update(const ArmState& arm, const JointReference& wanted) noexcept;

  /// y of the last update(), (n).
  const VectorXd& acceleration() const { return y_; }

 private:
  JointGains gains_;
  VectorXd y_, tau_;
};

}  // namespace veridyn
