#include "arm_loop.hpp"

#include <algorithm>
#include <cmath>

#include "loop_gains.hpp"
#include "veridyn/control/tip_controller.hpp"

namespace veridyn {
namespace {

// Keeps the posture in the null space of the task.
ImpedanceOptions posture_options(const VectorXd& posture) {
  ImpedanceOptions o;
  o.posture = posture;
  o.posture_p = kPostureStiffness;
  o.posture_d = kPostureDamping;
  return o;
}

// Largest torque of the observer of model errors [N m], [N]: well above the error of a model whose parameters
// are known to 10 %, so that this bound is not reached in normal operation.
constexpr double kObserverLimit = 20.0;

// Virtual mass and damping of an arm that yields to a force beyond its bound.
constexpr double kYieldingMass = 0.5;     // [kg]
constexpr double kYieldingDamping = 10.0;  // [N s/m]
constexpr double kCalm = 0.8;              // share of the bound below which yielding may end
constexpr double kRests = 0.005;           // [m/s] speed of the tip below which yielding may end
constexpr double kGoesAlong = 0.02;        // [m/s] relief velocity above which the arm follows a falling arm

ImpedanceGains yielding_gains() {
  ImpedanceGains g;
  g.mass.head<3>().setConstant(kYieldingMass);
  g.damping.head<3>().setConstant(kYieldingDamping);
  return g;
}

CycleOptions cycle_options(const ArmLoopSetup& setup) {
  const ScenarioControl& control = setup.control;
  CycleOptions o;
  o.velocity_bandwidth = 2.0 * M_PI * control.velocity_cutoff;
  o.friction.rule = control.friction_rule;
  o.friction.share = control.friction;
  o.error_bandwidth = 2.0 * M_PI * std::max(control.observer, 1e-3);
  o.error_limit = control.observer > 0.0 ? kObserverLimit : 0.0;
  o.supervision = Supervision::kLimits;
  o.signals = Signals::kTrue;
  return o;
}

}  // namespace

ArmLoop::ArmLoop(const ArmLoopSetup& setup)
    : setup_(setup),
      period_(1.0 / setup.control.rate),
      cycle_(setup.model, setup.tip, cycle_options(setup)),
      impedance_(setup.model, setup.tip,
                 impedance_gains(setup.control), posture_options(setup.start)),
      position_loop_(setup.model, setup.tip, position_gains(setup.control),
                     posture_options(setup.start)),
      yielding_loop_(setup.model, setup.tip, yielding_gains(), posture_options(setup.start)),
      inverse_(setup.model, setup.tip, TaskRows::kPosition),
      measured_(setup.model.joints()),
      rest_(VectorXd::Zero(setup.start.size())),
      joint_error_(rest_),
      wanted_dq_(rest_) {
  if (cycle_.friction() != nullptr && setup.control.adaptive_friction) {
    AdaptiveFrictionOptions options;
    options.enabled = true;
    adaptive_.emplace(*cycle_.friction(), options);
  }
  measure(setup.start);
}

void ArmLoop::measure(const VectorXd& q) noexcept {
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const double step = setup_.encoder_step[i];
    measured_.q[i] = step > 0.0 ? std::round(q[i] / step) * step : q[i];
  }
  const TipKinematics& tip = cycle_.measure(measured_, period_).tip();
  position_ = setup_.p_world_base + setup_.R_world_base * tip.position();
  velocity_ = setup_.R_world_base * tip.twist().head<3>();
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

// The target in the arm's base; if frozen, the held position plus the relief.
TaskReference ArmLoop::reference(const TipTarget& target) const noexcept {
  if (!frozen_) return in_base(target, setup_.p_world_base, setup_.R_world_base);
  TipTarget held;
  held.position = frozen_at_ + target.relief.position;
  held.velocity = target.relief.velocity;
  held.acceleration = target.relief.acceleration;
  return in_base(held, setup_.p_world_base, setup_.R_world_base);
}

const VectorXd& ArmLoop::torque(const TipTarget& target, const Eigen::Vector3d& force) noexcept {
  relief_ = target.relief.position;
  // An impedance would yield to forces, but would not follow a falling arm: a position loop does.
  const bool goes_along = target.relief.velocity.norm() > kGoesAlong;
  if (goes_along && yields_to_forces() && !yielding_) freeze();
  TaskReference wanted = reference(target);
  Vector6d wrench = Vector6d::Zero();
  if (yields_to_forces() || yielding_) wrench.head<3>() = setup_.R_world_base.transpose() * force;
  Impedance& loop = acting();
  if (yielding_) {  // The reference is the force at the bound: the excess moves the tip.
    const double size = force.norm();
    wanted = TaskReference();
    wanted.ddx.head<3>() =
        wrench.head<3>() * (std::min(1.0, bound_ / std::max(size, bound_)) / kYieldingMass);
    wanted.dx.head<3>() = setup_.R_world_base.transpose() * target.relief.velocity;
    wanted.ddx.head<3>() += setup_.R_world_base.transpose() * target.relief.acceleration;
  }
  cycle_.command(loop.update(cycle_.state(), wanted, wrench));
  if (!yielding_ && (!frozen_ || goes_along)) compensate_friction(wanted);
  cycle_.add_model_error(loop.acceleration());
  if (adaptive_ && !yielding_ && !frozen_)
    adaptive_->update(cycle_.state(), cycle_.error().missing(), period_, *cycle_.friction());
  return cycle_.send();
}

// Sets the velocity and the error of the joints from which friction is compensated.
void ArmLoop::compensate_friction(const TaskReference& wanted) noexcept {
  if (cycle_.friction() == nullptr) return;
  const TipKinematics& tip = cycle_.state().tip();
  inverse_.update(tip.jacobian());
  inverse_.solve(wanted.dx, rest_, wanted_dq_);
  Vector6d error = Vector6d::Zero();
  error.head<3>() = wanted.x.head<3>() - tip.position();
  inverse_.solve(error, rest_, joint_error_);
  cycle_.add_friction(wanted_dq_, joint_error_);
}

}  // namespace veridyn
