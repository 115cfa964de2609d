#include "veridyn/dynamics/rigid_body_dynamics.hpp"

#include <Eigen/Cholesky>
#include <cassert>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr Vec3d kNoGravity{0, 0, 0};

void require_state(const char* where, const Model& arm, const VectorRef& v, const char* name) {
  require(v.size() == arm.joints(), where, ": ", name, " has ", v.size(), " entries, but arm '", arm.name(),
          "' has ", arm.joints(), " joints.");
}

VectorXd own_values(const char* where, const Model& arm) {
  const auto phi = arm.inertial_values();
  require(phi.has_value(), where, ": arm '", arm.name(), "' has bodies without mass, com and inertia.");
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
  require(phi.size() == expected, "RigidBodyDynamics: phi has ", phi.size(), " entries, but arm '", arm.name(),
          "' has ", tree_.body_links.size(), " bodies with ", kBodyParameters, " each.");
}

void RigidBodyDynamics::inverse_dynamics(const VectorRef& q, const VectorRef& dq, const VectorRef& ddq,
                                         VectorXd& tau) {
  assert(q.size() == joints() && dq.size() == joints() && ddq.size() == joints() && tau.size() == joints());
  forward_pass(tree_, q.data(), dq.data(), ddq.data(), tree_.gravity, recursion_);
  backward_pass(tree_, phi_.data(), recursion_, tau.data());
}

void RigidBodyDynamics::gravity_torques(const VectorRef& q, VectorXd& g) { inverse_dynamics(q, rest_, rest_, g); }

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
    const auto* J = &recursion_.jacobian[static_cast<size_t>(k) * n];
    for (const int i : tree_.links[k].support) {
      // Momentum of the body per unit of dq_i, paired with the other columns.
      const Vec3d force = p[0] * J[i].v + cross(J[i].w, h);
      const Vec3d moment = inertia_times(p + 4, J[i].w) + cross(h, J[i].v);
      for (const int j : tree_.links[k].support) {
        if (j > i) break;
        M(i, j) += dot(J[j].w, moment) + dot(J[j].v, force);
      }
    }
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < i; ++j) M(j, i) = M(i, j);
  }
}

void RigidBodyDynamics::coriolis_matrix(const VectorRef& q, const VectorRef& dq, MatrixXd& C) {
  assert(q.size() == joints() && dq.size() == joints() && C.rows() == joints() && C.cols() == joints());
  const int n = joints();
  forward_pass(tree_, q.data(), dq.data(), rest_.data(), kNoGravity, recursion_);
  jacobian_pass(tree_, recursion_);
  jacobian_rate_pass(tree_, recursion_);
  C.setZero();
  for (size_t b = 0; b < tree_.body_links.size(); ++b) {
    const int k = tree_.body_links[b];
    const double* p = phi_.data() + 10 * b;
    const Vec3d h{p[1], p[2], p[3]};
    const auto* J = &recursion_.jacobian[static_cast<size_t>(k) * n];
    const auto* dJ = &recursion_.jacobian_rate[static_cast<size_t>(k) * n];
    Vec3d omega{0, 0, 0};
    Vec3d v{0, 0, 0};
    for (const int i : tree_.links[k].support) {
      omega = omega + dq[i] * J[i].w;
      v = v + dq[i] * J[i].v;
    }
    const Vec3d momentum = p[0] * v + cross(omega, h);
    const Vec3d spin = inertia_times(p + 4, omega) + cross(h, v);
    for (const int j : tree_.links[k].support) {
      // C = J' (I dJ + B J); B is skew, with B [w; v] = [w x spin + v x momentum; w x momentum] for the body's own twist.
      const Vec3d force = p[0] * dJ[j].v + cross(dJ[j].w, h) + cross(J[j].w, momentum);
      const Vec3d moment = inertia_times(p + 4, dJ[j].w) + cross(h, dJ[j].v) + cross(J[j].w, spin) +
                           cross(J[j].v, momentum);
      for (const int i : tree_.links[k].support) C(i, j) += dot(J[i].w, moment) + dot(J[i].v, force);
    }
  }
}

bool RigidBodyDynamics::forward_dynamics(const VectorRef& q, const VectorRef& dq, const VectorRef& tau,
                                         VectorXd& ddq) {
  inverse_dynamics(q, dq, rest_, bias_);
  mass_matrix(q, M_);
  const Eigen::LLT<Eigen::Ref<MatrixXd>> factor(M_);  // in place: nothing allocates
  if (factor.info() != Eigen::Success) return false;
  ddq = tau - bias_;
  factor.solveInPlace(ddq);
  return true;
}

MatrixXd torque_regressor(const Model& arm, const VectorRef& q, const VectorRef& dq, const VectorRef& ddq) {
  require_state("torque_regressor", arm, q, "q");
  require_state("torque_regressor", arm, dq, "dq");
  require_state("torque_regressor", arm, ddq, "ddq");
  const Tree tree(arm);
  Recursion<double> r(tree);
  forward_pass(tree, q.data(), dq.data(), ddq.data(), tree.gravity, r);
  jacobian_pass(tree, r);
  MatrixXd Y = MatrixXd::Zero(arm.joints(), static_cast<Eigen::Index>(kBodyParameters * tree.body_links.size()));
  double y[kBodyParameters];
  for (size_t b = 0; b < tree.body_links.size(); ++b) {
    const int k = tree.body_links[b];
    for (const int i : tree.links[k].support) {
      regressor_entries<double>(r.links[k], r.jacobian[static_cast<size_t>(k) * arm.joints() + i], y);
      for (int c = 0; c < kBodyParameters; ++c) Y(i, static_cast<Eigen::Index>(10 * b + c)) = y[c];
    }
  }
  return Y;
}

VectorXd inverse_dynamics(const Model& arm, const VectorRef& q, const VectorRef& dq, const VectorRef& ddq) {
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
