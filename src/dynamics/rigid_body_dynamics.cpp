#include "veridyn/dynamics/rigid_body_dynamics.hpp"

#include <cassert>
#include <cstdint>

#include "arm_kernels.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr std::size_t kAlignment = 64;

void require_state(const char* where, const Model& arm, const VectorRef& v, const char* name) {
  require(v.size() == arm.joints(), where, ": ", name, " has ", v.size(), " entries, but arm '",
          arm.name(), "' has ", arm.joints(), " joints.");
}

// The inertial parameters of all bodies; throws InvalidInput if a body has none.
VectorXd own_values(const char* where, const Model& arm) {
  const auto phi = arm.inertial_values();
  require(phi.has_value(), where, ": arm '", arm.name(),
          "' has bodies without mass, com and inertia.");
  return *phi;
}

}  // namespace

namespace internal {

AlignedWorkspace::AlignedWorkspace(std::size_t bytes)
    : memory_((bytes + kAlignment) / sizeof(double) + 1) {}

double* AlignedWorkspace::get() {
  const auto at = reinterpret_cast<std::uintptr_t>(memory_.data());
  return memory_.data() + (kAlignment - at % kAlignment) % kAlignment / sizeof(double);
}

}  // namespace internal

RigidBodyDynamics::RigidBodyDynamics(const Model& arm, const VectorRef& phi)
    : tree_(arm, Tree::Keep::kMovingLinks),
      inertia_(tree_.links.size()),
      memory_(arm_kernels().workspace(tree_)),
      M_(MatrixXd::Zero(arm.joints(), arm.joints())),
      tau_(VectorXd::Zero(arm.joints())),
      at_{M_, M_, M_} {
  const auto expected = static_cast<Eigen::Index>(kBodyParameters * tree_.bodies.size());
  require(phi.size() == expected, "RigidBodyDynamics: phi has ", phi.size(), " entries, but arm '",
          arm.name(), "' has ", tree_.bodies.size(), " bodies with ", kBodyParameters, " each.");
  const VectorXd stored = phi;
  link_inertias(tree_, stored.data(), inertia_.data());
  wrenches_.reserve(tree_.frames.size());
}

void RigidBodyDynamics::inverse_dynamics(const VectorRef& q, const VectorRef& dq,
                                         const VectorRef& ddq, VectorXd& tau) {
  assert(q.size() == joints() && dq.size() == joints() && ddq.size() == joints() &&
         tau.size() == joints());
  arm_kernels().inverse_dynamics({tree_, inertia_.data()}, q.data(), dq.data(), ddq.data(),
                                 nullptr, 0, tau.data(), memory_.get());
}

void RigidBodyDynamics::inverse_dynamics(const VectorRef& q, const VectorRef& dq,
                                         const VectorRef& ddq,
                                         const std::vector<FrameWrench>& external, VectorXd& tau) {
  assert(q.size() == joints() && dq.size() == joints() && ddq.size() == joints() &&
         tau.size() == joints() && external.size() <= tree_.frames.size());
  wrenches_.clear();
  for (const FrameWrench& w : external) {
    const BodyPlace& place = tree_.frames[w.frame.value];
    if (place.link < 0) continue;  // the body is fixed to the world
    const Posed& T = place.T_link_body;
    const Vec3d force = rotate(T.R, Vec3d{w.force.x(), w.force.y(), w.force.z()});
    const Vec3d moment = rotate(T.R, Vec3d{w.moment.x(), w.moment.y(), w.moment.z()});
    wrenches_.push_back({place.link, force, moment + cross(T.p, force)});
  }
  arm_kernels().inverse_dynamics({tree_, inertia_.data()}, q.data(), dq.data(), ddq.data(),
                                 wrenches_.data(), static_cast<int>(wrenches_.size()), tau.data(),
                                 memory_.get());
}

void RigidBodyDynamics::gravity_torques(const VectorRef& q, VectorXd& g) {
  assert(q.size() == joints() && g.size() == joints());
  arm_kernels().gravity_torques({tree_, inertia_.data()}, q.data(), g.data(), memory_.get());
}

void RigidBodyDynamics::mass_matrix(const VectorRef& q, MatrixXd& M) {
  assert(q.size() == joints() && M.rows() == joints() && M.cols() == joints());
  arm_kernels().mass_matrix({tree_, inertia_.data()}, q.data(), M.data(), memory_.get());
}

void RigidBodyDynamics::coriolis_matrix(const VectorRef& q, const VectorRef& dq, MatrixXd& C) {
  assert(q.size() == joints() && dq.size() == joints() && C.rows() == joints() &&
         C.cols() == joints());
  arm_kernels().velocity_derivative({tree_, inertia_.data()}, q.data(), dq.data(), 0.5, nullptr,
                                    nullptr, C.data(), memory_.get());
}

void RigidBodyDynamics::lagrangian_gradient(const VectorRef& q, const VectorRef& dq,
                                            VectorXd& gradient) {
  assert(q.size() == joints() && dq.size() == joints() && gradient.size() == joints());
  arm_kernels().lagrangian_gradient({tree_, inertia_.data()}, q.data(), dq.data(), gradient.data(),
                                    memory_.get());
}

void RigidBodyDynamics::equation_of_motion(const VectorRef& q, const VectorRef& dq, MatrixXd& M,
                                           VectorXd& h) noexcept {
  assert(q.size() == joints() && dq.size() == joints() && M.rows() == joints() &&
         M.cols() == joints() && h.size() == joints());
  arm_kernels().equation_of_motion({tree_, inertia_.data()}, q.data(), dq.data(), M.data(),
                                   h.data(), memory_.get());
}

void RigidBodyDynamics::equation_of_motion(const VectorRef& q, const VectorRef& dq, MatrixXd& M,
                                           VectorXd& h, MatrixXd& D) noexcept {
  assert(q.size() == h.size() && dq.size() == h.size() && M.rows() == h.size() &&
         D.rows() == h.size());
  arm_kernels().velocity_derivative({tree_, inertia_.data()}, q.data(), dq.data(), 1.0, M.data(),
                                    h.data(), D.data(), memory_.get());
}

void RigidBodyDynamics::equation_of_motion(const VectorRef& q, const VectorRef& dq,
                                           const VectorRef& ddq, const VectorRef& displacement,
                                           MatrixXd& M, VectorXd& h, MatrixXd& D,
                                           VectorXd& change) noexcept {
  assert(ddq.size() == h.size() && displacement.size() == h.size() && change.size() == h.size());
  inverse_dynamics_derivatives(q, dq, ddq, tau_, at_);
  M = at_.by_ddq;
  D = at_.by_dq;
  h = tau_;
  h.noalias() -= M * ddq;
  change.noalias() = at_.by_q * displacement;
}

bool RigidBodyDynamics::forward_dynamics(const VectorRef& q, const VectorRef& dq,
                                         const VectorRef& tau, VectorXd& ddq) {
  assert(q.size() == joints() && dq.size() == joints() && tau.size() == joints() &&
         ddq.size() == joints());
  return arm_kernels().forward_dynamics({tree_, inertia_.data()}, q.data(), dq.data(), tau.data(),
                                        ddq.data(), M_.data(), memory_.get());
}

void RigidBodyDynamics::inverse_dynamics_derivatives(const VectorRef& q, const VectorRef& dq,
                                                     const VectorRef& ddq, VectorXd& tau,
                                                     TorqueDerivatives& derivatives) {
  const int n = joints();
  assert(q.size() == n && dq.size() == n && ddq.size() == n);
  tau.resize(n);
  for (MatrixXd* m : {&derivatives.by_q, &derivatives.by_dq, &derivatives.by_ddq}) m->resize(n, n);
  arm_kernels().derivatives({tree_, inertia_.data()}, q.data(), dq.data(), ddq.data(), tau.data(),
                            derivatives.by_q.data(), derivatives.by_dq.data(),
                            derivatives.by_ddq.data(), memory_.get());
}

bool RigidBodyDynamics::forward_dynamics_derivatives(const VectorRef& q, const VectorRef& dq,
                                                     const VectorRef& tau, VectorXd& ddq,
                                                     AccelerationDerivatives& derivatives) {
  const int n = joints();
  assert(q.size() == n && dq.size() == n && tau.size() == n);
  ddq.resize(n);
  for (MatrixXd* m : {&derivatives.by_q, &derivatives.by_dq, &derivatives.by_tau}) m->resize(n, n);
  return arm_kernels().forward_derivatives(
      {tree_, inertia_.data()}, q.data(), dq.data(), tau.data(), ddq.data(),
      derivatives.by_q.data(), derivatives.by_dq.data(), derivatives.by_tau.data(), memory_.get());
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
