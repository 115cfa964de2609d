#pragma once

#include <memory>
#include <vector>

#include "veridyn/dynamics/recursion.hpp"
#include "veridyn/kinematics/tree.hpp"
#include "veridyn/math/types.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

class StateModel;  // internal

/// The rigid bodies of an arm in motion, in one convention (thesis 4.10 with the errata):
///
///   tau = M(q) ddq + C(q, dq) dq + g(q)
///
/// Friction and the other effects are not in here. Owns its workspace: after the constructor
/// nothing allocates, and one object serves one thread. Inputs must be stored vectors of n entries
/// (an expression passed for a VectorRef allocates); sizes are asserted, not thrown about, because
/// this runs in control loops.
class RigidBodyDynamics {
 public:
  /// @param phi  (10 * bodies) mass, first moments and inertias of all bodies, ten of each in the order
  ///             of InertialParameters; `*arm.inertial_values()` where the file or MODEL has them.
  /// @throws InvalidInput  phi has the wrong size.
  RigidBodyDynamics(const Model& arm, const VectorRef& phi);

  int joints() const { return tree_.joints; }

  /// tau, (n) [N m, N]. Cost: O(frames).
  void inverse_dynamics(const VectorRef& q, const VectorRef& dq, const VectorRef& ddq,
                        VectorXd& tau);

  /// g(q), (n).
  void gravity_torques(const VectorRef& q, VectorXd& g);

  /// M(q), (n x n), symmetric.
  void mass_matrix(const VectorRef& q, MatrixXd& M);

  /// C(q, dq), (n x n), the choice for which dM/dt - 2 C is skew symmetric.
  void coriolis_matrix(const VectorRef& q, const VectorRef& dq, MatrixXd& C);

  /// ddq from torques that act on the rigid bodies. False if M is not positive definite there.
  bool forward_dynamics(const VectorRef& q, const VectorRef& dq, const VectorRef& tau,
                        VectorXd& ddq);

  /// M(q), (n x n), and h = C(q, dq) dq + g(q), (n), at little more than the cost of M alone.
  void equation_of_motion(const VectorRef& q, const VectorRef& dq, MatrixXd& M, VectorXd& h);

  /// Derivatives of inverse dynamics, (n x n) each: column j is by coordinate j.
  struct TorqueSlopes {
    MatrixXd by_q, by_dq, by_ddq;  ///< by_ddq is M(q)
  };

  /// tau and its derivatives, analytically: tangents of the Newton-Euler recursion, eight
  /// directions side by side.
  void inverse_dynamics_slopes(const VectorRef& q, const VectorRef& dq, const VectorRef& ddq,
                               VectorXd& tau, TorqueSlopes& slopes);

  /// Derivatives of forward dynamics, (n x n) each.
  struct AccelerationSlopes {
    MatrixXd by_q, by_dq, by_tau;  ///< by_tau is the inverse of M(q)
  };

  /// ddq and its derivatives, from those of inverse dynamics at ddq: -M^-1 dtau/dx. False if M is
  /// not positive definite there.
  bool forward_dynamics_slopes(const VectorRef& q, const VectorRef& dq, const VectorRef& tau,
                               VectorXd& ddq, AccelerationSlopes& slopes);

 private:
  double* memory();

  Tree tree_;
  VectorXd phi_;
  VectorXd rest_;
  Recursion<double> recursion_;
  std::shared_ptr<const StateModel> state_;
  std::vector<double> memory_;
  MatrixXd M_;
  VectorXd bias_;
};

/// torque_regressor() of one arm again and again: after the constructor nothing allocates.
class TorqueRegressor {
 public:
  explicit TorqueRegressor(const Model& arm);

  /// @param Y  (n x 10 bodies), of the right size.
  void evaluate(const VectorRef& q, const VectorRef& dq, const VectorRef& ddq, MatrixXd& Y);

 private:
  std::shared_ptr<const StateModel> state_;
  std::vector<double> memory_;
};

/// Joint torques as a linear map of the bodies' inertial parameters:
///
///   tau = Y(q, dq, ddq) * phi
///
/// Columns 10b .. 10b+9 belong to body b, in the order of InertialParameters.
/// Source: Atkeson, An and Hollerbach, IJRR 5(3), 1986. Cost: O(bodies * n).
///
/// @param q, dq, ddq  (n) [rad, rad/s, rad/s^2]; metres where the joint is prismatic.
/// @returns Y (n x 10 bodies); row i is coordinate i, in [N m] ([N] if prismatic) per unit of phi.
/// @throws InvalidInput  a vector does not have arm.joints() entries.
MatrixXd torque_regressor(const Model& arm, const VectorRef& q, const VectorRef& dq,
                          const VectorRef& ddq);

/// Joint torques of the arm's own inertial parameters. @throws InvalidInput as above, or a body has
/// no values.
VectorXd inverse_dynamics(const Model& arm, const VectorRef& q, const VectorRef& dq,
                          const VectorRef& ddq);

/// M(q) of the arm's own parameters, (n x n).
MatrixXd mass_matrix(const Model& arm, const VectorRef& q);

/// C(q, dq) of the arm's own parameters, (n x n).
MatrixXd coriolis_matrix(const Model& arm, const VectorRef& q, const VectorRef& dq);

}  // namespace veridyn
