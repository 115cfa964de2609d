#include "veridyn/dynamics/equation_of_motion.hpp"

#include <cassert>

#include "arm_kernels.hpp"

namespace veridyn {

EquationOfMotion::EquationOfMotion(const Model& arm, const VectorRef& phi)
    : bodies_(arm, phi), tau_(VectorXd::Zero(arm.joints())) {
  for (MatrixXd* m : {&at_.by_q, &at_.by_dq, &at_.by_ddq}) m->setZero(arm.joints(), arm.joints());
}

void EquationOfMotion::evaluate(const VectorXd& q, const VectorXd& dq, MatrixXd& M,
                                VectorXd& h) noexcept {
  bodies_.equation_of_motion(q, dq, M, h);
}

void EquationOfMotion::evaluate_with_derivative(const VectorXd& q, const VectorXd& dq, MatrixXd& M,
                                                VectorXd& h, MatrixXd& D) noexcept {
  assert(q.size() == h.size() && dq.size() == h.size() && M.rows() == h.size() &&
         D.rows() == h.size());
  arm_kernels().velocity_derivative({bodies_.tree_, bodies_.inertia_.data()}, q.data(), dq.data(), 1.0,
                                    M.data(), h.data(), D.data(), bodies_.memory_.get());
}

void EquationOfMotion::evaluate_linearized(const VectorXd& q, const VectorXd& dq,
                                           const VectorXd& ddq, const VectorXd& displacement,
                                           MatrixXd& M, VectorXd& h, MatrixXd& D,
                                           VectorXd& change) noexcept {
  assert(ddq.size() == h.size() && displacement.size() == h.size() && change.size() == h.size());
  bodies_.inverse_dynamics_derivatives(q, dq, ddq, tau_, at_);
  M = at_.by_ddq;
  D = at_.by_dq;
  h = tau_;
  h.noalias() -= M * ddq;
  change.noalias() = at_.by_q * displacement;
}

}  // namespace veridyn
