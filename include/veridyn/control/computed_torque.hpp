#pragma once

#include "veridyn/control/arm_state.hpp"
#include "veridyn/math/types.hpp"

namespace veridyn {

/// Reference of the joints, (n) each: positions [rad], velocities [rad/s] and accelerations [rad/s^2]; metres
/// where a joint is prismatic.
struct JointReference {
  explicit JointReference(int joints) : q(VectorXd::Zero(joints)), dq(q), ddq(q) {}
  VectorXd q, dq, ddq;
};

/// Diagonals of K_p [1/s^2] and K_d [1/s], (n) each. They are normalised by the inertia: the error
/// of a joint obeys e'' + K_d e' + K_p e = 0.
struct JointGains {
  VectorXd p, d;
};

/// Computed torque: the model linearises the arm to a double integrator (thesis 7.1 to 7.5, with
/// the reference acceleration, which the thesis omits):
///
///   y   = ddq_d + K_p (q_d - q) + K_d (dq_d - dq)
///   tau = M(q) y + bias(q, dq)
///
/// FrictionCompensation and ModelErrorObserver add friction and the model's error:
///
///   state.update(q, dq);
///   tau = control.update(state, wanted);
///   tau += friction.update(state, wanted.dq, error, dt);  // stored vectors
///   tau += model_error.update(state, control.acceleration(), dt);
class ComputedTorque {
 public:
  /// @throws InvalidInput  gains that are not `joints` finite numbers, or one below zero.
  ComputedTorque(int joints, const JointGains& gains);

  /// @returns tau (n), valid until the next update().
  /// Vectors have the sizes of the constructor; debug builds assert it.
  const VectorXd& update(const ArmState& arm, const JointReference& wanted) noexcept;

  /// y of the last update(), (n).
  const VectorXd& acceleration() const { return y_; }

 private:
  JointGains gains_;
  VectorXd y_, tau_;
};

}  // namespace veridyn
