#include "veridyn/control/control_cycle.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <ostream>
#include <vector>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr double kGiveWayDamping = 5.0;  // [1/s] rate of damping in command_gravity_compensation()

// Number of cycles between two evaluations of TorqueUncertainty, whose cost grows with the model's covariance;
// in between, the motion hardly changes.
constexpr int kLimitEvery = 16;

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

// The limits of the options or of the robot file; throws InvalidInput if a supervisor lacks a torque limit.
SafetyLimits limits_of(const Model& arm, const CycleOptions& options) {
  if (options.limits) return *options.limits;
  if (options.supervision == Supervision::kSupervisor && !(options.torque > 0.0)) {
    for (const Coordinate& c : arm.coordinates()) {
      require(std::isfinite(c.limits.effort), "controller: found no torque limit of coordinate '",
              c.name, "' of '", arm.name(),
              "', expected `limits: {effort: ...}` in the robot file or CycleOptions::torque.");
    }
  }
  const double torque = options.torque > 0.0 ? options.torque : std::numeric_limits<double>::infinity();
  return safety_limits(arm, torque);
}

// Options of the observer. A disabled one has a valid bandwidth and a limit of zero.
ModelErrorOptions observer_of(const Model& arm, const CycleOptions& options) {
  ModelErrorOptions out;
  out.limit = VectorXd::Zero(arm.joints());
  require(options.error_bandwidth >= 0.0, "controller: found an error bandwidth of ",
          options.error_bandwidth, " 1/s, expected none below zero.");
  if (options.error_bandwidth == 0.0) return out;
  out.bandwidth = options.error_bandwidth;
  if (options.error_limit) out.limit = options.error_limit->expand(arm.joints(), "error limit");
  return out;
}

}  // namespace

std::ostream& operator<<(std::ostream& out, const ControllerFault& fault) {
  out << describe(fault.what);
  if (fault.joint) out << " of joint " << fault.joint->value + 1;
  return out << " at " << fault.time << " s";
}

Tip chosen_tip(const Model& arm, const Tip& tip) {
  require(arm.joints() > 0, "controller: found no arm, expected a MODEL with values, as identify() or diagnose() made it.");
  return tip.frame.empty() ? Tip{default_tip(arm), tip.offset_frame} : tip;
}

ControlCycle::ControlCycle(const Model& arm, const Tip& tip, const CycleOptions& options)
    : sensors_(options.signals == Signals::kOfSensors
                   ? JointSensors(arm)
                   : JointSensors(std::vector<RecordedChannel>(static_cast<std::size_t>(arm.joints())))),
      velocity_(arm.joints(), options.velocity_bandwidth),
      state_(arm, tip),
      error_(arm.joints(), observer_of(arm, options)),
      limits_(limits_of(arm, options)),
      input_(arm.joints()),
      observes_(options.error_bandwidth > 0.0),
      q_(VectorXd::Zero(arm.joints())),
      dq_(q_),
      y_(q_),
      tau_(q_),
      sent_(q_),
      drive_(q_) {
  if (options.friction.share > 0.0) friction_.emplace(arm, options.friction);
  if (observes_ && !options.error_limit) uncertainty_.emplace(arm);
  if (options.supervision == Supervision::kSupervisor) safety_.emplace(arm, limits_);
  require(limits_.torque.size() == q_.size(), "controller: found torque limits of ",
          limits_.torque.size(), " entries, expected ", q_.size(), ".");
  input_.force_expected.setConstant(kUnknown);
  reset_observers();
}

const ArmState& ControlCycle::measure(const Measured& measured, double dt) noexcept {
  assert(measured.q.size() == q_.size() && (measured.dq.size() == 0 || measured.dq.size() == q_.size()));
  q_ = measured.q;
  sensors_.correct_positions(q_);
  if (measured.dq.size() == q_.size()) {
    dq_ = measured.dq;
  } else {
    dq_ = velocity_.update(q_, y_, dt);
  }
  state_.update(q_, dq_);
  dt_ = dt;
  if (std::isfinite(dt)) time_ += dt;
  input_.q_wanted.setConstant(kUnknown);
  input_.dt = dt;
  input_.sensor_age = measured.age;
  input_.sensor_age_range = measured.age_range;
  wrench_ = measured.wrench;
  input_.force = measured.wrench.head<3>();
  input_.force_age = measured.wrench_age;
  y_.setZero();
  observed_ = false;
  return state_;
}

void ControlCycle::add_friction(const VectorRef& dq_wanted, const VectorRef& error) noexcept {
  if (friction_) tau_ += friction_->update(state_, dq_wanted, error, dt_);
}

void ControlCycle::add_model_error(const VectorRef& y) noexcept {
  y_ = y;
  if (!observes_) return;
  if (uncertainty_ && until_limit_-- == 0) {
    error_.set_limit(uncertainty_->update(state_, y_));  // refuses limits that are not finite
    until_limit_ = kLimitEvery - 1;
  }
  tau_ += error_.update(state_, y_, dt_);
  observed_ = true;
}

void ControlCycle::command_gravity_compensation() noexcept {
  y_ = -kGiveWayDamping * state_.dq();
  tau_ = state_.bias();
  tau_.noalias() += state_.mass_matrix().lazyProduct(y_);
  input_.q_wanted.setConstant(kUnknown);
  observed_ = false;
}

const VectorXd& ControlCycle::send() noexcept {
  if (limp_) command_gravity_compensation();
  if (!observed_) error_.reset();
  if (safety_) {
    safety_->set_holding_torque(error_.torque());
    sent_ = safety_->update(state_, input_, tau_);
    if (safety_->fault() != known_) {
      known_ = safety_->fault();
      fault_time_ = time_;
    }
  } else {
    for (Eigen::Index i = 0; i < tau_.size(); ++i) {
      const double most = limits_.torque[i];
      sent_[i] = std::isfinite(tau_[i]) && !off_ ? std::clamp(tau_[i], -most, most) : 0.0;
    }
  }
  error_.set_sent_torques(tau_, sent_);
  // Joints whose torque was not sent as computed do not have the acceleration of the law.
  for (Eigen::Index i = 0; i < y_.size(); ++i) {
    if (sent_[i] != tau_[i]) y_[i] = 0.0;
  }
  drive_ = sent_;
  sensors_.add_torque_errors(drive_);
  return drive_;
}

void ControlCycle::set_sent_torques(const VectorRef& drive_torques) noexcept {
  sent_ = drive_torques;
  sensors_.correct_torques(sent_);
  error_.set_sent_torques(tau_, sent_);
}

bool ControlCycle::hold() noexcept {
  if (!safety_ || !safety_->hold()) return false;
  limp_ = false;
  return true;
}

void ControlCycle::limp() noexcept {
  resume();
  limp_ = true;
}

void ControlCycle::resume() noexcept {
  if (safety_) safety_->activate();
  limp_ = false;
}

void ControlCycle::reset_observers() noexcept {
  velocity_.reset();
  if (friction_) friction_->reset();
  error_.reset();
  y_.setZero();
  until_limit_ = 0;
  if (!safety_ || off_) return;
  safety_->disable();  // this does not clear a fault
  safety_->enable();
  safety_->activate();
}

void ControlCycle::reset() noexcept {
  if (safety_) safety_->reset();
  known_ = SafetyFault::kNone;
  time_ = fault_time_ = 0.0;
  limp_ = off_ = false;
  reset_observers();
}

void ControlCycle::disable() noexcept {
  reset();
  if (safety_) safety_->disable();
  off_ = true;
}

std::optional<ControllerFault> ControlCycle::fault() const noexcept {
  if (known_ == SafetyFault::kNone) return std::nullopt;
  return ControllerFault{known_, safety_->joint(), fault_time_};
}

}  // namespace veridyn
