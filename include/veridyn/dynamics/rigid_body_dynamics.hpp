#pragma once

#include <vector>

#include "veridyn/dynamics/link_inertia.hpp"
#include "veridyn/kinematics/tree.hpp"
#include "veridyn/math/types.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// A wrench that the environment exerts on the arm at the origin of a frame, written in that frame.
struct FrameWrench {
  int frame = 0;  ///< index in the model
  Eigen::Vector3d force{0, 0, 0};   ///< [N]
  Eigen::Vector3d moment{0, 0, 0};  ///< [N m]
};

namespace internal {

/// Memory whose first double is aligned for the widest vectors; copies have one of their own.
class AlignedWorkspace {
 public:
  explicit AlignedWorkspace(std::size_t bytes);
  double* get();

 private:
  std::vector<double> memory_;
};

}  // namespace internal

/// Rigid-body dynamics of an arm, in one sign convention (thesis 4.10 with the errata):
///
///   tau = M(q) ddq + C(q, dq) dq + g(q)
///
/// Friction and the other effects are not included. Owns its workspace: after the constructor
/// nothing allocates, and one object serves one thread. Inputs must be stored vectors of n entries
/// (an expression passed for a VectorRef allocates); sizes are asserted and not checked at run
/// time, because this runs in control loops. The algorithms are those of arm_algorithms.hpp,
/// compiled for doubles
/// and for the widest vectors that the processor has.
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

  /// The same under external wrenches w: tau = M ddq + C dq + g - sum of J' w. At most as many
  /// wrenches as the arm has frames.
  void inverse_dynamics(const VectorRef& q, const VectorRef& dq, const VectorRef& ddq,
                        const std::vector<FrameWrench>& external, VectorXd& tau);

  /// g(q), (n).
  void gravity_torques(const VectorRef& q, VectorXd& g);

  /// M(q), (n x n), symmetric.
  void mass_matrix(const VectorRef& q, MatrixXd& M);

  /// C(q, dq), (n x n), of Christoffel's symbols: dM/dt - 2 C is skew symmetric.
  void coriolis_matrix(const VectorRef& q, const VectorRef& dq, MatrixXd& C);

  /// dL/dq = C(q, dq)' dq - g(q), (n), of the Lagrangian L = dq' M dq / 2 - U: with p = M dq, torques
  /// tau change p by dp/dt = tau + dL/dq. Cost: O(frames), without C.
  void lagrangian_gradient(const VectorRef& q, const VectorRef& dq, VectorXd& gradient);

  /// ddq from torques that act on the rigid bodies. False if M is not positive definite there.
  bool forward_dynamics(const VectorRef& q, const VectorRef& dq, const VectorRef& tau,
                        VectorXd& ddq);

  /// M(q), (n x n), and h = C(q, dq) dq + g(q), (n), at little more than the cost of M alone.
  void equation_of_motion(const VectorRef& q, const VectorRef& dq, MatrixXd& M, VectorXd& h);

  /// Derivatives of inverse dynamics, (n x n) each: column j is by coordinate j.
  struct TorqueDerivatives {
    MatrixXd by_q, by_dq, by_ddq;  ///< by_ddq is M(q)
  };

  /// tau and its analytical derivatives by tangents of the Newton-Euler recursion, several
  /// directions side by side.
  void inverse_dynamics_derivatives(const VectorRef& q, const VectorRef& dq, const VectorRef& ddq,
                                    VectorXd& tau, TorqueDerivatives& derivatives);

  /// Derivatives of forward dynamics, (n x n) each.
  struct AccelerationDerivatives {
    MatrixXd by_q, by_dq, by_tau;  ///< by_tau is the inverse of M(q)
  };

  /// ddq and its derivatives, from those of inverse dynamics at ddq: -M^-1 dtau/dx. False if M is
  /// not positive definite there.
  bool forward_dynamics_derivatives(const VectorRef& q, const VectorRef& dq, const VectorRef& tau,
                                    VectorXd& ddq, AccelerationDerivatives& derivatives);

 private:
  friend class EquationOfMotion;

  Tree tree_;
  std::vector<LinkInertia> inertia_;
  internal::AlignedWorkspace memory_;
  std::vector<LinkWrench> wrenches_;
  MatrixXd M_;
};

/// torque_regressor() of one arm for repeated calls: after the constructor nothing allocates.
class TorqueRegressor {
 public:
  explicit TorqueRegressor(const Model& arm);

  /// @param Y  (n x 10 bodies), of the right size.
  void evaluate(const VectorRef& q, const VectorRef& dq, const VectorRef& ddq, MatrixXd& Y);

 private:
  Tree tree_;
  internal::AlignedWorkspace memory_;
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

/// Joint torques with the inertial parameters of the model. @throws InvalidInput as above, or a
/// body has no values.
VectorXd inverse_dynamics(const Model& arm, const VectorRef& q, const VectorRef& dq,
                          const VectorRef& ddq);

/// M(q) with the inertial parameters of the model, (n x n).
MatrixXd mass_matrix(const Model& arm, const VectorRef& q);

/// C(q, dq) with the inertial parameters of the model, (n x n).
MatrixXd coriolis_matrix(const Model& arm, const VectorRef& q, const VectorRef& dq);

}  // namespace veridyn
