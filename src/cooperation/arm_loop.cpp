#include "arm_loop.hpp"

#include <algorithm>
#include <cmath>

namespace veridyn {
namespace {

ImpedanceGains gains(const Eigen::Vector3d& m, const Eigen::Vector3d& d, const Eigen::Vector3d& k) {
  ImpedanceGains g;
  g.mass.head<3>() = m;
  g.damping.head<3>() = d;
  g.stiffness.head<3>() = k;
  return g;
}

// Of a mass of one: accelerations, whatever the arm's inertia.
ImpedanceGains position_gains(double frequency) {
  const double omega = 2.0 * M_PI * frequency;
  const Eigen::Vector3d one = Eigen::Vector3d::Ones();
  return gains(one, 2.0 * omega * one, omega * omega * one);
}

ImpedanceOptions options(const VectorXd& posture) {
  ImpedanceOptions o;
  o.posture = posture;
  return o;
}

bool is_friction(const EffectTerm& term) {
  return term.effect == "viscous_friction" || term.effect == "coulomb_friction";
}

}  // namespace

ArmLoop::ArmLoop(const ArmLoopSetup& setup)
    : setup_(setup),
      period_(1.0 / setup.control.rate),
      state_(setup.model, setup.tip),
      impedance_(setup.model, setup.tip,
                 gains(setup.control.mass, setup.control.damping, setup.control.stiffness),
                 options(setup.start)),
      position_loop_(setup.model, setup.tip, position_gains(setup.control.position_frequency),
                     options(setup.start)),
      inverse_(setup.model, setup.tip, TaskRows::kPosition),
      q_(setup.start),
      dq_(VectorXd::Zero(setup.start.size())),
      raw_(q_),
      tau_(dq_),
      error_(dq_),
      momentum_(dq_),
      expected_(dq_),
      wanted_dq_(dq_) {
  for (const EffectTerm& term : setup.model.effects()) {
    if (is_friction(term)) friction_.emplace_back(setup.model, term);
  }
  measure(setup.start);
}

void ArmLoop::measure(const VectorXd& q) noexcept {
  raw_ = q;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const double step = setup_.encoder_step[i];
    if (step > 0.0) raw_[i] = std::round(q[i] / step) * step;
  }
  const double share = 1.0 - std::exp(-2.0 * M_PI * setup_.control.velocity_cutoff * period_);
  if (started_) dq_ += share * ((raw_ - q_) / period_ - dq_);
  started_ = true;
  q_ = raw_;
  state_.update(q_, dq_);
  position_ = setup_.p_world_base + setup_.R_world_base * state_.tip().position();
  velocity_ = setup_.R_world_base * state_.tip().twist().head<3>();
}

void ArmLoop::freeze() noexcept {
  frozen_ = true;
  frozen_at_ = position_;
}

TaskReference ArmLoop::reference(const TipTarget& target) const noexcept {
  TaskReference wanted;
  const auto in_base = setup_.R_world_base.transpose();
  if (frozen_) {
    wanted.x.head<3>() = in_base * (frozen_at_ - setup_.p_world_base);
    return wanted;
  }
  wanted.x.head<3>() = in_base * (target.position - setup_.p_world_base);
  wanted.dx.head<3>() = in_base * target.velocity;
  wanted.ddx.head<3>() = in_base * target.acceleration;
  return wanted;
}

// What accelerates the arm beside the torques that the model explains, low-passed:
//   d(M dq)/dt = tau - bias - J' h + error
void ArmLoop::observe() noexcept {
  const double omega = 2.0 * M_PI * setup_.control.observer;
  if (!(omega > 0.0)) return;
  momentum_.noalias() = state_.mass_matrix().lazyProduct(dq_);
  error_ = omega * (momentum_ - expected_);
}

const VectorXd& ArmLoop::torque(const TipTarget& target, const Eigen::Vector3d& force) noexcept {
  observe();
  const TaskReference wanted = reference(target);
  Vector6d wrench = Vector6d::Zero();
  const bool gives_way = setup_.kind == ArmControl::kImpedance && !frozen_;
  if (gives_way) wrench.head<3>() = setup_.R_world_base.transpose() * force;
  tau_ = gives_way ? impedance_.update(state_, wanted, wrench)
                   : position_loop_.update(state_, wanted, wrench);
  compensate_friction(target);
  if (setup_.control.observer > 0.0) {
    tau_ -= error_;
    expected_ += period_ * (tau_ - state_.bias() + error_);
    expected_.noalias() -= period_ * state_.tip().jacobian().transpose().lazyProduct(wrench);
  }
  for (Eigen::Index i = 0; i < tau_.size(); ++i) {
    const double limit = setup_.model.coordinates()[static_cast<size_t>(i)].limits.effort;
    if (std::isfinite(limit)) tau_[i] = std::clamp(tau_[i], -limit, limit);
  }
  return tau_;
}

// Friction at the velocity that is wanted, so that what moves by itself is never fed.
void ArmLoop::compensate_friction(const TipTarget& target) noexcept {
  if (frozen_ || !(setup_.control.friction > 0.0)) return;
  Vector6d v = Vector6d::Zero();
  v.head<3>() = setup_.R_world_base.transpose() * target.velocity;
  momentum_.setZero();
  inverse_.update(state_.tip().jacobian());
  inverse_.solve(v, momentum_, wanted_dq_);
  for (BoundEffect& effect : friction_) {
    const AxisSample sample = effect.sample(0.0, q_.data(), wanted_dq_.data(), error_.data(), 1);
    tau_ += setup_.control.friction * effect.force(sample) * effect.term().axis.coefficients;
  }
}

}  // namespace veridyn
