#pragma once

#include "veridyn/dynamics/rigid_body_dynamics.hpp"

namespace veridyn {

/// M(q) and h(q, dq) = C(q, dq) dq + g(q) at one state, and their first-order changes, for
/// integrators. After the constructor nothing allocates; one object serves one thread.
class EquationOfMotion {
 public:
  /// @param phi  (10 * bodies) of all bodies, ten of each in the order of InertialParameters;
  ///             `*arm.inertial_values()` where the file or MODEL has them.
  /// @throws InvalidInput  phi has the wrong size.
  EquationOfMotion(const Model& arm, const VectorRef& phi);

  /// @param q, dq  n entries each. @param M (n x n), @param h (n): of the right size.
  void evaluate(const VectorXd& q, const VectorXd& dq, MatrixXd& M, VectorXd& h) noexcept;

  /// Computes D = dh/d(dq), (n x n), as well.
  void evaluate_with_derivative(const VectorXd& q, const VectorXd& dq, MatrixXd& M, VectorXd& h,
                                MatrixXd& D) noexcept;

  /// Computes also the first-order change of M ddq + h over a small displacement of q, (n).
  void evaluate_linearized(const VectorXd& q, const VectorXd& dq, const VectorXd& ddq,
                           const VectorXd& displacement, MatrixXd& M, VectorXd& h, MatrixXd& D,
                           VectorXd& change) noexcept;

 private:
  RigidBodyDynamics bodies_;
  VectorXd tau_;
  RigidBodyDynamics::TorqueDerivatives at_;
};

}  // namespace veridyn
