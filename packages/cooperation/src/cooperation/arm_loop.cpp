#include "arm_loop.hpp"

#include <algorithm>
#include <cmath>

#include "loop_gains.hpp"

namespace veridyn {
namespace {

ImpedanceOptions options(const VectorXd& posture) {
  ImpedanceOptions o;
  o.posture = posture;
  o.posture_p = kPostureStiffness;
  o.posture_d = kPostureDamping;
  return o;
}

// Largest torque of the observer [N m], [N]: the arm is known to within a tenth, so this never
// binds.
constexpr double kObserverLimit = 20.0;

// A light virtual mass that yields to forces beyond a bound.
constexpr double kYieldingMass = 0.5;     // [kg]
constexpr double kYieldingDamping = 10.0;  // [N s/m]
constexpr double kCalm = 0.8;              // of the bound
constexpr double kRests = 0.005;           // [m/s]
constexpr double kGoesAlong = 0.02;        // [m/s]

ImpedanceGains yielding_gains() {
  ImpedanceGains g;
  g.mass.head<3>().setConstant(kYieldingMass);
  g.damping.head<3>().setConstant(kYieldingDamping);
  return g;
}

ModelErrorOptions observer(const ScenarioControl& control, Eigen::Index joints) {
  ModelErrorOptions o;
  o.bandwidth = 2.0 * M_PI * std::max(control.observer, 1e-3);
  o.limit = VectorXd::Constant(joints, control.observer > 0.0 ? kObserverLimit : 0.0);
  return o;
}

FrictionOptions friction(const ScenarioControl& control) {
  FrictionOptions o;
  o.rule = control.friction_rule;
  o.share = control.friction;
  return o;
}

}  // namespace

ArmLoop::ArmLoop(const ArmLoopSetup& setup)
    : setup_(setup),
      period_(1.0 / setup.control.rate),
      state_(setup.model, setup.tip),
      impedance_(setup.model, setup.tip,
                 impedance_gains(setup.control), options(setup.start)),
      position_loop_(setup.model, setup.tip, position_gains(setup.control),
                     options(setup.start)),
      yielding_loop_(setup.model, setup.tip, yielding_gains(), options(setup.start)),
      inverse_(setup.model, setup.tip, TaskRows::kPosition),
      velocity_observer_(setup.model.joints(), 2.0 * M_PI * setup.control.velocity_cutoff),
      model_error_(setup.model.joints(), observer(setup.control, setup.start.size())),
      q_(setup.start),
      rest_(VectorXd::Zero(setup.start.size())),
      tau_(rest_),
      asked_(rest_),
      joint_error_(rest_),
      wanted_dq_(rest_) {
  if (setup.control.friction > 0.0) friction_.emplace(setup.model, friction(setup.control));
  if (friction_ && setup.control.adaptive_friction) {
    AdaptiveFrictionOptions options;
    options.enabled = true;
    adaptive_.emplace(*friction_, options);
  }
  measure(setup.start);
}

void ArmLoop::measure(const VectorXd& q) noexcept {
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const double step = setup_.encoder_step[i];
    q_[i] = step > 0.0 ? std::round(q[i] / step) * step : q[i];
  }
  state_.update(q_, velocity_observer_.update(q_, acting().acceleration(), period_));
  position_ = setup_.p_world_base + setup_.R_world_base * state_.tip().position();
  velocity_ = setup_.R_world_base * state_.tip().twist().head<3>();
}

void ArmLoop::freeze() noexcept {
  if (frozen_) return;
  frozen_ = true;
  frozen_at_ = position_ - relief_;
}

void ArmLoop::hold_within(double bound, const Eigen::Vector3d& force) noexcept {
  bound_ = bound;
  const double size = force.norm();
  if (!yielding_) {
    yielding_ = size > bound;
    return;
  }
  if (size > kCalm * bound || velocity_.norm() > kRests) return;
  yielding_ = false;
  frozen_ = true;
  frozen_at_ = position_ - relief_;
}

TaskReference ArmLoop::reference(const TipTarget& target) const noexcept {
  TaskReference wanted;
  const auto in_base = setup_.R_world_base.transpose();
  if (frozen_) {
    wanted.x.head<3>() = in_base * (frozen_at_ + target.relief.position - setup_.p_world_base);
    wanted.dx.head<3>() = in_base * target.relief.velocity;
    wanted.ddx.head<3>() = in_base * target.relief.acceleration;
    return wanted;
  }
  wanted.x.head<3>() = in_base * (target.position - setup_.p_world_base);
  wanted.dx.head<3>() = in_base * target.velocity;
  wanted.ddx.head<3>() = in_base * target.acceleration;
  return wanted;
}

const VectorXd& ArmLoop::torque(const TipTarget& target, const Eigen::Vector3d& force) noexcept {
  relief_ = target.relief.position;
  // An impedance yields to forces, but does not follow a falling arm.
  const bool goes_along = target.relief.velocity.norm() > kGoesAlong;
  if (goes_along && gives_way() && !yielding_) freeze();
  TaskReference wanted = reference(target);
  Vector6d wrench = Vector6d::Zero();
  if (gives_way() || yielding_) wrench.head<3>() = setup_.R_world_base.transpose() * force;
  Impedance& loop = acting();
  if (yielding_) {  // The reference is the force within the bound: the excess moves the tip.
    const double size = force.norm();
    wanted = TaskReference();
    wanted.ddx.head<3>() =
        wrench.head<3>() * (std::min(1.0, bound_ / std::max(size, bound_)) / kYieldingMass);
    wanted.dx.head<3>() = setup_.R_world_base.transpose() * target.relief.velocity;
    wanted.ddx.head<3>() += setup_.R_world_base.transpose() * target.relief.acceleration;
  }
  tau_ = loop.update(state_, wanted, wrench);
  if (friction_ && !yielding_ && (!frozen_ || goes_along)) compensate_friction(wanted);
  tau_ += model_error_.update(state_, loop.acceleration(), period_);
  if (adaptive_ && !yielding_ && !frozen_)
    adaptive_->update(state_, model_error_.missing(), period_, *friction_);
  asked_ = tau_;
  for (Eigen::Index i = 0; i < tau_.size(); ++i) {
    const double limit = setup_.model.coordinates()[i].limits.effort;
    if (std::isfinite(limit)) tau_[i] = std::clamp(tau_[i], -limit, limit);
  }
  sent(tau_);
  return tau_;
}

void ArmLoop::compensate_friction(const TaskReference& wanted) noexcept {
  inverse_.update(state_.tip().jacobian());
  inverse_.solve(wanted.dx, rest_, wanted_dq_);
  Vector6d error = Vector6d::Zero();
  error.head<3>() = wanted.x.head<3>() - state_.tip().position();
  inverse_.solve(error, rest_, joint_error_);
  tau_ += friction_->update(state_, wanted_dq_, joint_error_, period_);
}

}  // namespace veridyn
