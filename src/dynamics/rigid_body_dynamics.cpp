#include "veridyn/dynamics/rigid_body_dynamics.hpp"

#include <Eigen/Cholesky>
#include <cassert>

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
      M_(MatrixXd::Zero(arm.joints(), arm.joints())),
      bias_(rest_) {
  const auto expected = static_cast<Eigen::Index>(kBodyParameters * tree_.body_links.size());
  require(phi.size() == expected, "RigidBodyDynamics: phi has ", phi.size(), " entries, but arm '",
          arm.name(), "' has ", tree_.body_links.size(), " bodies with ", kBodyParameters,
          " each.");
}

void RigidBodyDynamics::inverse_dynamics(const VectorRef& q, const VectorRef& dq,
                                         const VectorRef& ddq, VectorXd& tau) {
  assert(q.size() == joints() && dq.size() == joints() && ddq.size() == joints() &&
         tau.size() == joints());
  forward_pass(tree_, q.data(), dq.data(), ddq.data(), tree_.gravity, recursion_);
  backward_pass(tree_, phi_.data(), recursion_, tau.data());
}

void RigidBodyDynamics::gravity_torques(const VectorRef& q, VectorXd& g) {
  inverse_dynamics(q, rest_, rest_, g);
}

void RigidBodyDynamics::mass_matrix(const VectorRef& q, MatrixXd& M) {
  assert(q.size() == joints() && M.rows() == joints() && M.cols() == joints());
  const int n = joints();
  forward_pass(tree_, q.data(), rest_.data(), rest_.data(), kNoGravity, recursion_);
  jacobian_pass(tree_, recursion_);
  M.setZero();
  for (size_t b = 0; b < tree_.body_links.size(); ++b) {
    const int k = tree_.body_links[b];
    const double* p = phi_.data() + 10 * b;
    const Vec3d h{p[1], p[2], p[3]};
    const Column<double>* J = recursion_.jacobian;
    for (int m = tree_.links[k].first_mover; m < tree_.links[k].end_mover; ++m) {
      // Momentum of the body per unit of dq_i, paired with the columns up to i.
      const int i = tree_.movers[m].coordinate;
      const Vec3d force = p[0] * J[m].v + cross(J[m].w, h);
      const Vec3d moment = inertia_times(p + 4, J[m].w) + cross(h, J[m].v);
      for (int o = tree_.links[k].first_mover; o <= m; ++o) {
        M(i, tree_.movers[o].coordinate) += dot(J[o].w, moment) + dot(J[o].v, force);
      }
    }
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < i; ++j) M(j, i) = M(i, j);
  }
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
  inverse_dynamics(q, dq, rest_, bias_);
  mass_matrix(q, M_);
  const Eigen::LLT<Eigen::Ref<MatrixXd>> factor(M_);  // in place: nothing allocates
  if (factor.info() != Eigen::Success) return false;
  ddq = tau - bias_;
  factor.solveInPlace(ddq);
  return true;
}

MatrixXd torque_regressor(const Model& arm, const VectorRef& q, const VectorRef& dq,
                          const VectorRef& ddq) {
  require_state("torque_regressor", arm, q, "q");
  require_state("torque_regressor", arm, dq, "dq");
  require_state("torque_regressor", arm, ddq, "ddq");
  const Tree tree(arm);
  Recursion<double> r(tree);
  forward_pass(tree, q.data(), dq.data(), ddq.data(), tree.gravity, r);
  jacobian_pass(tree, r);
  MatrixXd Y = MatrixXd::Zero(arm.joints(),
                              static_cast<Eigen::Index>(kBodyParameters * tree.body_links.size()));
  for (size_t b = 0; b < tree.body_links.size(); ++b) {
    const int k = tree.body_links[b];
    const BodyMotion<double> motion = body_motion(r.link[k]);
    for (int m = tree.links[k].first_mover; m < tree.links[k].end_mover; ++m) {
      const int i = tree.movers[m].coordinate;
      const auto first = static_cast<Eigen::Index>(kBodyParameters * b);
      regressor_entries(motion, r.jacobian[m], [&](int c, double y) { Y(i, first + c) = y; });
    }
  }
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
