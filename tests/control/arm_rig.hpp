#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "support/random.hpp"
#include "veridyn/control/arm_state.hpp"
#include "veridyn/control/velocity_observer.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/simulation/engine.hpp"

// A simulated arm as a controller sees it: encoder steps, velocities from them, a force sensor that
// is noisy and one cycle late, motors that hold their torque for a cycle and have limits.

namespace veridyn {

constexpr double kPeriod = 1e-3;  // [s] of the controllers

class ArmRig {
 public:
  /// What the tip exerts on the world, from its position and velocity.
  using World = std::function<Eigen::Vector3d(const Eigen::Vector3d&, const Eigen::Vector3d&)>;

  ArmRig(const Model& real, const Tip& tip, const std::string& engine = "veridyn")
      : engine_(make_engine(engine, real)),
        tip_(real, tip),
        velocity_(real.joints()),
        step_(real.joints()),
        limit_(real.joints()),
        q_(VectorXd::Zero(real.joints())),
        none_(q_),
        motors_(q_),
        all_(q_) {
    for (int i = 0; i < real.joints(); ++i) {
      const Coordinate& c = real.coordinates()[i];
      step_[i] = c.prismatic ? 1.29e-6 : 7.72e-6;  // the dVRK's encoders
      limit_[i] = c.limits.effort;
    }
  }

  void set_world(World world) { world_ = std::move(world); }
  void set_limit(const VectorXd& limit) { limit_ = limit; }

  void place(const VectorXd& q) {
    engine_->set_state(q, none_);
    velocity_.reset();
    force_.setZero();
    read();
    force_ = exerted();
    sensed_ = force_sensor_ = force_;
  }

  /// One cycle under these torques.
  StepStatus cycle(const VectorXd& tau) {
    motors_ = tau.cwiseMin(limit_).cwiseMax(-limit_);
    sensed_ = force_sensor_;
    const int steps = world_ ? 8 : 1;
    for (int k = 0; k < steps; ++k) {
      all_ = motors_;
      if (world_) all_ -= tip_.jacobian().topRows<3>().transpose() * exerted();
      const StepStatus status = engine_->step(all_, kPeriod / steps);
      if (status != StepStatus::kOk) return status;
      if (world_) tip_.update(engine_->q(), engine_->dq());
    }
    read();
    force_ = exerted();
    if (world_) {
      for (double& f : force_sensor_) f = force_noise_ * (noise_.in(-1, 1) + noise_.in(-1, 1));
      force_sensor_ += force_;
    }
    return StepStatus::kOk;
  }

  /// What sensors say.
  const VectorXd& q() const { return q_; }
  const VectorXd& dq() const { return velocity_.dq(); }
  Vector6d wrench() const {
    Vector6d h = Vector6d::Zero();
    h.head<3>() = sensed_;
    return h;
  }

  /// What is true.
  Engine& engine() { return *engine_; }
  const TipKinematics& tip() const { return tip_; }
  const Eigen::Vector3d& force() const { return force_; }
  const VectorXd& motors() const { return motors_; }

 private:
  Eigen::Vector3d exerted() const {
    return world_ ? world_(tip_.position(), tip_.twist().head<3>()) : Eigen::Vector3d::Zero();
  }
  void read() {
    tip_.update(engine_->q(), engine_->dq());
    for (Eigen::Index i = 0; i < q_.size(); ++i)
      q_[i] = std::round(engine_->q()[i] / step_[i]) * step_[i];
    velocity_.update(q_, none_, kPeriod);
  }

  std::unique_ptr<Engine> engine_;
  TipKinematics tip_;
  VelocityObserver velocity_;
  VectorXd step_, limit_, q_, none_, motors_, all_;
  Eigen::Vector3d force_{0, 0, 0}, force_sensor_{0, 0, 0}, sensed_{0, 0, 0};
  double force_noise_ = 0.02;  // [N]
  Random noise_{77};
  World world_;
};

/// Every inertial parameter and every parameter of an effect wrong by +-share, the sign by chance.
inline Model with_wrong_parameters(const Model& arm, double share, unsigned seed) {
  Random random(seed);
  const auto wrong = [&] { return random.in(-1, 1) < 0.0 ? 1.0 - share : 1.0 + share; };
  ModelDescription description = arm.description();
  for (Frame& frame : description.frames) {
    if (!frame.body) continue;
    for (double& p : *frame.body->phi) p *= wrong();
  }
  for (EffectTerm& term : description.effects) {
    for (const EffectParameter& p : find_effect(term.effect).parameters())
      term.values[p.name] *= wrong();
  }
  return Model(std::move(description));
}

/// Every friction's parameters times `share`.
inline Model with_scaled_friction(const Model& arm, double share) {
  ModelDescription description = arm.description();
  for (EffectTerm& term : description.effects) {
    if (term.effect.find("friction") == std::string::npos &&
        term.effect.find("visc") == std::string::npos && term.effect != "presliding_hysteresis")
      continue;
    for (const EffectParameter& p : find_effect(term.effect).parameters())
      term.values[p.name] *= share;
  }
  return Model(std::move(description));
}

}  // namespace veridyn
