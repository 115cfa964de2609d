#include "veridyn/dynamics/rigid_body_dynamics.hpp"

#include <cassert>

#include "state_model.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr Vec3d kNoGravity{0, 0, 0};

void require_state(const char* where, const Model& arm, const VectorRef& v, const char* name) {
  require(v.size() == arm.joints(), where, ": ", name, " has ", v.size(), " entries, but arm '",
          arm.name(), "' has ", arm.joints(), " joints.");
}

VectorXd own_values(const char* where, const Model& arm) {
  const auto phi = arm.inertial_values();
  require(phi.has_value(), where, ": arm '", arm.name(),
          "' has bodies without mass, com and inertia.");
  return *phi;
}

}  // namespace

RigidBodyDynamics::RigidBodyDynamics(const Model& arm, const VectorRef& phi)
    : tree_(arm),
      phi_(phi),
      rest_(VectorXd::Zero(arm.joints())),
      recursion_(tree_),
      state_(std::make_shared<StateModel>(tree_, phi_)),
      memory_(state_->workspace()),
      M_(MatrixXd::Zero(arm.joints(), arm.joints())),
      bias_(rest_) {
  const auto expected = static_cast<Eigen::Index>(kBodyParameters * tree_.body_links.size());
  require(phi.size() == expected, "RigidBodyDynamics: phi has ", phi.size(), " entries, but arm '",
          arm.name(), "' has ", tree_.body_links.size(), " bodies with ", kBodyParameters,
          " each.");
}

double* RigidBodyDynamics::memory() {
  return StateModel::aligned(memory_);
}

void RigidBodyDynamics::inverse_dynamics(const VectorRef& q, const VectorRef& dq,
                                         const VectorRef& ddq, VectorXd& tau) {
  assert(q.size() == joints() && dq.size() == joints() && ddq.size() == joints() &&
         tau.size() == joints());
  state_kernels().inverse_dynamics(state_->view(), q.data(), dq.data(), ddq.data(), tau.data(),
                                   memory());
}

void RigidBodyDynamics::gravity_torques(const VectorRef& q, VectorXd& g) {
  assert(q.size() == joints() && g.size() == joints());
  state_kernels().inverse_dynamics(state_->view(), q.data(), nullptr, nullptr, g.data(), memory());
}

void RigidBodyDynamics::mass_matrix(const VectorRef& q, MatrixXd& M) {
  assert(q.size() == joints() && M.rows() == joints() && M.cols() == joints());
  state_kernels().mass_matrix(state_->view(), q.data(), M.data(), memory());
}

void RigidBodyDynamics::equation_of_motion(const VectorRef& q, const VectorRef& dq, MatrixXd& M,
                                           VectorXd& h) {
  assert(q.size() == joints() && dq.size() == joints() && M.rows() == joints() &&
         M.cols() == joints() && h.size() == joints());
  state_kernels().equation(state_->view(), q.data(), dq.data(), M.data(), h.data(), memory());
}

void RigidBodyDynamics::inverse_dynamics_slopes(const VectorRef& q, const VectorRef& dq,
                                                const VectorRef& ddq, VectorXd& tau,
                                                TorqueSlopes& slopes) {
  const int n = joints();
  assert(q.size() == n && dq.size() == n && ddq.size() == n);
  tau.resize(n);
  for (MatrixXd* m : {&slopes.by_q, &slopes.by_dq, &slopes.by_ddq}) m->resize(n, n);
  state_kernels().slopes(state_->view(), q.data(), dq.data(), ddq.data(), tau.data(),
                         slopes.by_q.data(), slopes.by_dq.data(), slopes.by_ddq.data(), memory());
}

bool RigidBodyDynamics::forward_dynamics_slopes(const VectorRef& q, const VectorRef& dq,
                                                const VectorRef& tau, VectorXd& ddq,
                                                AccelerationSlopes& slopes) {
  const int n = joints();
  ddq.resize(n);
  if (!forward_dynamics(q, dq, tau, ddq)) return false;
  for (MatrixXd* m : {&slopes.by_q, &slopes.by_dq, &slopes.by_tau}) m->resize(n, n);
  const StateKernels& kernels = state_kernels();
  kernels.slopes(state_->view(), q.data(), dq.data(), ddq.data(), bias_.data(),
                 slopes.by_q.data(), slopes.by_dq.data(), M_.data(), memory());
  if (!kernels.factor(n, M_.data())) return false;
  slopes.by_tau.setIdentity();
  kernels.solve(n, M_.data(), n, slopes.by_tau.data());
  for (MatrixXd* m : {&slopes.by_q, &slopes.by_dq}) {
    *m = -*m;
    kernels.solve(n, M_.data(), n, m->data());
  }
  return true;
}

void RigidBodyDynamics::coriolis_matrix(const VectorRef& q, const VectorRef& dq, MatrixXd& C) {
  assert(q.size() == joints() && dq.size() == joints() && C.rows() == joints() &&
         C.cols() == joints());
  forward_pass(tree_, q.data(), dq.data(), rest_.data(), kNoGravity, recursion_);
  jacobian_pass(tree_, recursion_);
  jacobian_rate_pass(tree_, recursion_);
  C.setZero();
  for (size_t b = 0; b < tree_.body_links.size(); ++b) {
    const int k = tree_.body_links[b];
    const double* p = phi_.data() + 10 * b;
    const Vec3d h{p[1], p[2], p[3]};
    const Column<double>* J = recursion_.jacobian;
    const Column<double>* dJ = recursion_.jacobian_rate;
    const int first = tree_.links[k].first_mover;
    const int end = tree_.links[k].end_mover;
    Vec3d omega{0, 0, 0};
    Vec3d v{0, 0, 0};
    for (int m = first; m < end; ++m) {
      omega = omega + dq[tree_.movers[m].coordinate] * J[m].w;
      v = v + dq[tree_.movers[m].coordinate] * J[m].v;
    }
    const Vec3d momentum = p[0] * v + cross(omega, h);
    const Vec3d spin = inertia_times(p + 4, omega) + cross(h, v);
    for (int m = first; m < end; ++m) {
      // C = J' (I dJ + B J); B is skew, with B [w; v] = [w x spin + v x momentum; w x momentum] for
      // the body's own twist.
      const Vec3d force = p[0] * dJ[m].v + cross(dJ[m].w, h) + cross(J[m].w, momentum);
      const Vec3d moment = inertia_times(p + 4, dJ[m].w) + cross(h, dJ[m].v) + cross(J[m].w, spin) +
                           cross(J[m].v, momentum);
      for (int o = first; o < end; ++o) {
        C(tree_.movers[o].coordinate, tree_.movers[m].coordinate) +=
            dot(J[o].w, moment) + dot(J[o].v, force);
      }
    }
  }
}

bool RigidBodyDynamics::forward_dynamics(const VectorRef& q, const VectorRef& dq,
                                         const VectorRef& tau, VectorXd& ddq) {
  assert(q.size() == joints() && dq.size() == joints() && tau.size() == joints() &&
         ddq.size() == joints());
  const bool solved = state_kernels().forward_dynamics(state_->view(), q.data(), dq.data(),
                                                       tau.data(), bias_.data(), M_.data(), memory());
  if (solved) ddq = bias_;  // which may be where tau stands
  return solved;
}

TorqueRegressor::TorqueRegressor(const Model& arm)
    : state_(std::make_shared<StateModel>(Tree(arm), VectorXd())), memory_(state_->workspace()) {}

void TorqueRegressor::evaluate(const VectorRef& q, const VectorRef& dq, const VectorRef& ddq,
                               MatrixXd& Y) {
  const StateTree tree = state_->view();
  assert(q.size() == tree.coordinates && dq.size() == tree.coordinates &&
         ddq.size() == tree.coordinates && Y.rows() == tree.coordinates &&
         Y.cols() == kBodyParameters * tree.bodies);
  state_kernels().regressor(tree, q.data(), dq.data(), ddq.data(), Y.data(),
                            StateModel::aligned(memory_));
}

MatrixXd torque_regressor(const Model& arm, const VectorRef& q, const VectorRef& dq,
                          const VectorRef& ddq) {
  require_state("torque_regressor", arm, q, "q");
  require_state("torque_regressor", arm, dq, "dq");
  require_state("torque_regressor", arm, ddq, "ddq");
  MatrixXd Y(arm.joints(), static_cast<Eigen::Index>(kBodyParameters * arm.bodies().size()));
  TorqueRegressor(arm).evaluate(q, dq, ddq, Y);
  return Y;
}

VectorXd inverse_dynamics(const Model& arm, const VectorRef& q, const VectorRef& dq,
                          const VectorRef& ddq) {
  require_state("inverse_dynamics", arm, q, "q");
  require_state("inverse_dynamics", arm, dq, "dq");
  require_state("inverse_dynamics", arm, ddq, "ddq");
  RigidBodyDynamics dynamics(arm, own_values("inverse_dynamics", arm));
  VectorXd tau(arm.joints());
  dynamics.inverse_dynamics(q, dq, ddq, tau);
  return tau;
}

MatrixXd mass_matrix(const Model& arm, const VectorRef& q) {
  require_state("mass_matrix", arm, q, "q");
  RigidBodyDynamics dynamics(arm, own_values("mass_matrix", arm));
  MatrixXd M(arm.joints(), arm.joints());
  dynamics.mass_matrix(q, M);
  return M;
}

MatrixXd coriolis_matrix(const Model& arm, const VectorRef& q, const VectorRef& dq) {
  require_state("coriolis_matrix", arm, q, "q");
  require_state("coriolis_matrix", arm, dq, "dq");
  RigidBodyDynamics dynamics(arm, own_values("coriolis_matrix", arm));
  MatrixXd C(arm.joints(), arm.joints());
  dynamics.coriolis_matrix(q, dq, C);
  return C;
}

}  // namespace veridyn
