#pragma once

#include <Eigen/Core>
#include <vector>

#include "veridyn/dynamics/arm_algorithms.hpp"
#include "veridyn/kinematics/tree.hpp"

namespace veridyn {

/// RigidBodyDynamics over any scalar S: float, dual numbers, the types of automatic differentiation
/// and of symbolic packages, with + - * /, a constructor from double and a function
/// `sine_cosine(const S& x, S& sine, S& cosine)` beside them. Header-only, with Eigen alone:
///
///     Tree tree(2, {0, 0, -9.81});                  // or Tree(model, Tree::Keep::kMovingLinks)
///     tree.add_body(tree.add_link(-1, JointType::kRevolute, {{0, 1.0}}, 0.0, T_base_joint));
///     ...
///     ArmDynamics<S> arm(tree, phi.data());
///     arm.inverse_dynamics(q, dq, ddq, tau);
///
/// After the constructor nothing allocates, unless S itself does; outputs are of the right size.
/// One object serves one thread.
template <typename S>
class ArmDynamics {
 public:
  using Vector = Eigen::Matrix<S, Eigen::Dynamic, 1>;
  using Matrix = Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic>;

  /// @param tree  tree of moving links, in which B is the identity. @param phi  ten parameters of every body.
  ArmDynamics(const Tree& tree, const double* phi)
      : tree_(tree),
        inertia_(tree.links.size()),
        memory_(Algorithms::workspace(tree_) / sizeof(S)),
        matrix_(static_cast<std::size_t>(tree.joints) * static_cast<std::size_t>(tree.joints)) {
    link_inertias(tree_, phi, inertia_.data());
  }

  /// tau = M(q) ddq + C(q, dq) dq + g(q).
  void inverse_dynamics(const Vector& q, const Vector& dq, const Vector& ddq, Vector& tau) {
    Algorithms::inverse_dynamics(links(), q.data(), dq.data(), ddq.data(), nullptr, 0, tau.data(),
                                 memory());
  }
  void gravity_torques(const Vector& q, Vector& g) {
    Algorithms::gravity_torques(links(), q.data(), g.data(), memory());
  }
  void mass_matrix(const Vector& q, Matrix& M) {
    Algorithms::mass_matrix(links(), q.data(), M.data(), memory());
  }
  /// Coriolis matrix of Christoffel's symbols.
  void coriolis_matrix(const Vector& q, const Vector& dq, Matrix& C) {
    Algorithms::velocity_derivative(links(), q.data(), dq.data(), 0.5, nullptr, nullptr, C.data(),
                                    memory());
  }
  /// Solves for ddq. False if M is not positive definite; scalars that cannot be compared are not checked.
  bool forward_dynamics(const Vector& q, const Vector& dq, const Vector& tau, Vector& ddq) {
    return Algorithms::forward_dynamics(links(), q.data(), dq.data(), tau.data(), ddq.data(),
                                        matrix_.data(), memory());
  }
  /// Computes tau and its derivatives; the one by ddq is M.
  void inverse_dynamics_derivatives(const Vector& q, const Vector& dq, const Vector& ddq,
                                    Vector& tau, Matrix& by_q, Matrix& by_dq, Matrix& M) {
    Algorithms::derivatives(links(), q.data(), dq.data(), ddq.data(), tau.data(), by_q.data(),
                            by_dq.data(), M.data(), memory());
  }
  /// Computes ddq and its derivatives; the one by tau is the inverse of M. False as forward_dynamics().
  bool forward_dynamics_derivatives(const Vector& q, const Vector& dq, const Vector& tau,
                                    Vector& ddq, Matrix& by_q, Matrix& by_dq, Matrix& by_tau) {
    return Algorithms::forward_derivatives(links(), q.data(), dq.data(), tau.data(), ddq.data(),
                                           by_q.data(), by_dq.data(), by_tau.data(), memory());
  }
  /// Y, (n x 10 bodies).
  void regressor(const Vector& q, const Vector& dq, const Vector& ddq, Matrix& Y) {
    Algorithms::regressor(tree_, q.data(), dq.data(), ddq.data(), Y.data(), memory());
  }

 private:
  using Algorithms = ArmAlgorithms<S>;

  InertialLinks links() const { return {tree_, inertia_.data()}; }
  typename Algorithms::Memory memory() { return Algorithms::divide(tree_, memory_.data()); }

  Tree tree_;
  std::vector<LinkInertia> inertia_;
  std::vector<S> memory_;  // the parts of Algorithms::Memory are made of S alone
  std::vector<S> matrix_;
};

}  // namespace veridyn
