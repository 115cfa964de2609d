// dynamics/: inverse and forward dynamics of rigid bodies, their derivatives and regressor, by one recursion.
#pragma once

#include <vector>

#include "veridyn/dynamics/aligned_workspace.hpp"
#include "veridyn/dynamics/link_inertia.hpp"
#include "veridyn/dynamics/torque_regressor.hpp"
#include "veridyn/kinematics/tree.hpp"
#include "veridyn/math/types.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// A wrench that the environment exerts on the arm at the origin of a frame, written in that frame.
struct FrameWrench {
  FrameIndex frame;
  Eigen::Vector3d force{0, 0, 0};   ///< [N]
  Eigen::Vector3d moment{0, 0, 0};  ///< [N m]
};

/// Rigid-body dynamics of an arm, in one sign convention (thesis 4.10 with the errata):
///
///   tau = M(q) ddq + C(q, dq) dq + g(q)
///
/// Friction and the other effects are not included. Owns its workspace: after the constructor
/// nothing allocates, and one object serves one thread. Inputs must be stored vectors of n entries
/// (an expression passed for a VectorRef allocates); sizes are asserted and not checked at run
/// time, because this runs in control loops. The algorithms are those of arm_algorithms.hpp,
/// compiled for doubles and for the widest vectors that the processor has.
class RigidBodyDynamics {
 public:
  /// @param phi  (10 * bodies) mass, first moments and inertias of all bodies, ten of each in the order
  ///             of InertialParameters; `*arm.inertial_values()` where the file or identified model has them.
  /// @throws InvalidInput  phi has the wrong size.
  RigidBodyDynamics(const Model& arm, const VectorRef& phi);

  int joints() const { return tree_.joints; }

  /// tau, (n) [N m, N]. Cost: O(frames).
  void inverse_dynamics(const VectorRef& q, const VectorRef& dq, const VectorRef& ddq,
                        VectorXd& tau);

  /// Inverse dynamics under external wrenches w: tau = M ddq + C dq + g - sum of J' w. At most as many wrenches
  /// as the arm has frames.
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
  /// Cost: O(n), or O(n^3) where a coordinate moves several joints (see ArmAlgorithms).
  bool forward_dynamics(const VectorRef& q, const VectorRef& dq, const VectorRef& tau,
                        VectorXd& ddq);

  /// M(q), (n x n), and h = C(q, dq) dq + g(q), (n), at little more than the cost of M alone.
  void equation_of_motion(const VectorRef& q, const VectorRef& dq, MatrixXd& M,
                          VectorXd& h) noexcept;

  /// Also computes D = dh/d(dq), (n x n).
  void equation_of_motion(const VectorRef& q, const VectorRef& dq, MatrixXd& M, VectorXd& h,
                          MatrixXd& D) noexcept;

  /// Also computes the first-order change of M ddq + h over a small displacement of q, (n).
  void equation_of_motion(const VectorRef& q, const VectorRef& dq, const VectorRef& ddq,
                          const VectorRef& displacement, MatrixXd& M, VectorXd& h, MatrixXd& D,
                          VectorXd& change) noexcept;

  /// Derivatives of inverse dynamics, (n x n) each: column j is by coordinate j.
  struct TorqueDerivatives {
    MatrixXd by_q, by_dq, by_ddq;  ///< by_ddq is M(q)
  };

  /// tau and its analytical derivatives. Cost: O(n^2).
  void inverse_dynamics_derivatives(const VectorRef& q, const VectorRef& dq, const VectorRef& ddq,
                                    VectorXd& tau, TorqueDerivatives& derivatives);

  /// Derivatives of forward dynamics, (n x n) each.
  struct AccelerationDerivatives {
    MatrixXd by_q, by_dq, by_tau;  ///< by_tau is the inverse of M(q)
  };

  /// ddq and its derivatives: -M^-1 dtau/dx at that ddq. False if M is not positive definite there.
  /// Cost: O(n^2), or O(n^3) as above.
  bool forward_dynamics_derivatives(const VectorRef& q, const VectorRef& dq, const VectorRef& tau,
                                    VectorXd& ddq, AccelerationDerivatives& derivatives);

 private:
  Tree tree_;
  std::vector<LinkInertia> inertia_;
  internal::AlignedWorkspace memory_;
  std::vector<LinkWrench> wrenches_;
  MatrixXd M_;
  VectorXd tau_;
  TorqueDerivatives at_;
};

/// Joint torques with the inertial parameters of the model. @throws InvalidInput  a vector does
/// not have arm.joints() entries, or a body has no values.
VectorXd inverse_dynamics(const Model& arm, const VectorRef& q, const VectorRef& dq,
                          const VectorRef& ddq);

/// M(q) with the inertial parameters of the model, (n x n).
MatrixXd mass_matrix(const Model& arm, const VectorRef& q);

/// C(q, dq) with the inertial parameters of the model, (n x n).
MatrixXd coriolis_matrix(const Model& arm, const VectorRef& q, const VectorRef& dq);

}  // namespace veridyn
