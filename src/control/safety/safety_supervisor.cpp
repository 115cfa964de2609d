#include "veridyn/control/safety_supervisor.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "control/safety/position_limit.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr double kHoldStiffness = 100.0;  // [1/s^2] stiffness about the position where the arm stopped
constexpr double kBlindBraking = 0.8;     // share of the momentum that kFreeze removes; friction removes the rest
// Ratio of a jump to the largest displacement between two measurements at the velocity limit. It is above
// SafetyLimits::runaway, 1.5, at which an arm that runs away is stopped.
constexpr double kJumpShare = 2.0;

// Share of a motor's limit: a motor at rest with a larger torque is blocked.
constexpr double kNearLimit = 0.95;

// A position counts as newly measured if its time of measurement has advanced by this share of a cycle.
constexpr double kNewer = 0.5;

// Rank of a fault by its action; the highest rank applies.
int strength(SafetyFault fault) {
  switch (action_of(fault)) {
    case SafetyAction::kMotorsOff:
      return 4;
    case SafetyAction::kFreeze:
      return 3;
    case SafetyAction::kRelease:
      return 2;
    case SafetyAction::kHold:
      return 1;
    case SafetyAction::kPass:
      break;
  }
  return 0;
}

std::optional<JointIndex> first_not_finite(const VectorRef& v) {
  for (Eigen::Index i = 0; i < v.size(); ++i) {
    if (!std::isfinite(v[i])) return JointIndex{static_cast<int>(i)};
  }
  return std::nullopt;
}

}  // namespace

SafetyLimits safety_limits(const Model& arm, double torque) {
  SafetyLimits limits;
  const auto n = static_cast<Eigen::Index>(arm.joints());
  limits.lower = limits.upper = limits.velocity = limits.torque = limits.tracking =
      VectorXd::Zero(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Coordinate& c = arm.coordinates()[i];
    limits.lower[i] = c.limits.lower;
    limits.upper[i] = c.limits.upper;
    limits.velocity[i] = c.limits.velocity;
    limits.torque[i] = std::isfinite(c.limits.effort) ? c.limits.effort : torque;
    const double range = c.limits.upper - c.limits.lower;
    limits.tracking[i] = std::isfinite(range) ? 0.05 * range : (c.prismatic ? 0.02 : 0.1);
  }
  return limits;
}

SafetySupervisor::SafetySupervisor(const Model& arm, const SafetyLimits& limits)
    : limits_(limits),
      gravity_(arm),
      uncertainty_(arm, {limits.model_error}),
      sound_(arm, {arm.frames().back().name}),
      saturated_(VectorXd::Zero(arm.joints())) {
  const auto n = static_cast<Eigen::Index>(arm.joints());
  if (limits_.resolution.size() == 0) limits_.resolution = VectorXd::Zero(n);
  for (const VectorXd* v : {&limits_.lower, &limits_.upper, &limits_.velocity, &limits_.torque,
                            &limits_.tracking, &limits_.resolution})
    require(v->size() == n, "SafetySupervisor: found limits of ", v->size(), " entries, but arm '",
            arm.name(), "' has ", n, " joints.");
  // The comparison is true for no NaN, whereas minCoeff() may skip one.
  const auto above_zero = [](const VectorRef& v) { return (v.array() > 0.0).all(); };
  require(above_zero(limits.upper - limits.lower) && above_zero(limits.velocity) &&
              above_zero(limits.torque) && limits.torque.allFinite() && above_zero(limits.tracking) &&
              (limits_.resolution.array() >= 0.0).all() && std::isfinite(limits.braking),
          "SafetySupervisor: found limits without room between them, or not above zero, or no "
          "finite torque or braking.");
  for (const double v : {limits.force, limits.force_disagreement, limits.disagreement_seconds,
                         limits.sensor_age, limits.force_age, limits.overrun, limits.torque_seconds,
                         limits.homing_share, limits.braking, limits.held_seconds,
                         limits.rest_share, limits.runaway, limits.model_error})
    require(v > 0.0, "SafetySupervisor: found a limit of ", v, ", expected one above zero.");
  q_sound_ = q_hold_ = frozen_ = momentum_ = extra_ = VectorXd::Zero(n);
  extra_sound_ = load_ = rest_ = y_ = out_ = extra_;
}

bool SafetySupervisor::enable() noexcept {
  if (state_ != SafetyState::kDisabled || fault_ != SafetyFault::kNone) return false;
  state_ = SafetyState::kReady;
  stopped_ = seen_ = watched_ = false;
  return true;
}

bool SafetySupervisor::home() noexcept {
  if (state_ != SafetyState::kReady) return false;
  state_ = SafetyState::kHoming;
  return true;
}

bool SafetySupervisor::homed() noexcept {
  if (state_ != SafetyState::kHoming) return false;
  state_ = SafetyState::kReady;
  stopped_ = false;
  return true;
}

bool SafetySupervisor::activate() noexcept {
  if (state_ != SafetyState::kReady && state_ != SafetyState::kHolding) return false;
  state_ = SafetyState::kActive;
  return true;
}

bool SafetySupervisor::hold() noexcept {
  if (state_ != SafetyState::kActive) return false;
  state_ = SafetyState::kHolding;
  stopped_ = false;
  return true;
}

void SafetySupervisor::disable() noexcept {
  if (state_ != SafetyState::kFault) state_ = SafetyState::kDisabled;
}

bool SafetySupervisor::reset() noexcept {
  if (state_ != SafetyState::kFault) return false;
  state_ = SafetyState::kDisabled;
  fault_ = SafetyFault::kNone;
  joint_.reset();
  disagreed_ = fault_for_ = 0.0;
  events_ = 0;
  saturated_.setZero();
  return true;
}

void SafetySupervisor::set_holding_torque(const VectorRef& extra) noexcept {
  assert(extra.size() == extra_.size());
  if (state_ == SafetyState::kFault) return;  // torques of an inactive controller are not checked
  for (Eigen::Index i = 0; i < extra_.size(); ++i)
    extra_[i] = std::isfinite(extra[i]) ? extra[i] : 0.0;
}

SafetySupervisor::Finding SafetySupervisor::check_sensors(const ArmState& arm,
                                                          const SafetyInput& input) const noexcept {
  for (const VectorXd* v : {&arm.q(), &arm.dq()}) {
    const std::optional<JointIndex> joint = first_not_finite(*v);
    if (joint) return {SafetyFault::kNotFinite, joint};
  }
  if (!std::isfinite(input.dt) || !std::isfinite(input.sensor_age) || !std::isfinite(input.sensor_age_range))
    return {SafetyFault::kNotFinite, {}};
  if (input.sensor_age > limits_.sensor_age) return {SafetyFault::kSensorAge, {}};
  if (!seen_) return {};
  const double time = std::max(since_sound_ + input.sensor_age_range, 0.0);
  for (Eigen::Index i = 0; i < q_sound_.size(); ++i) {
    const double farthest = kJumpShare * limits_.velocity[i] * time + limits_.resolution[i];
    if (std::abs(arm.q()[i] - q_sound_[i]) > farthest)
      return {SafetyFault::kEncoderJump, {{static_cast<int>(i)}}};
  }
  return {};
}

SafetySupervisor::Finding SafetySupervisor::check_motion(const ArmState& arm,
                                                         const SafetyInput& input) const noexcept {
  if (input.dt > limits_.overrun) return {SafetyFault::kOverrun, {}};
  for (Eigen::Index i = 0; i < q_sound_.size(); ++i) {
    const JointIndex joint{static_cast<int>(i)};
    const PositionRange range{limits_.lower[i], limits_.upper[i]};
    if (leaves_range(arm.q()[i], arm.dq()[i], range, limits_.braking))
      return {SafetyFault::kPosition, joint};
    const double share = state_ == SafetyState::kHoming ? limits_.homing_share : 1.0;
    if (std::abs(arm.dq()[i]) > share * limits_.velocity[i]) return {SafetyFault::kVelocity, joint};
    // The comparison is false if the reference is NaN.
    if (std::abs(input.q_wanted[i] - arm.q()[i]) > limits_.tracking[i])
      return {SafetyFault::kTracking, joint};
  }
  return {};
}

SafetySupervisor::Finding SafetySupervisor::check_motors(const ArmState& arm, const SafetyInput& input,
                                                         const VectorRef& tau) noexcept {
  const std::optional<JointIndex> joint = first_not_finite(tau);
  if (joint) return {SafetyFault::kController, joint};
  for (Eigen::Index i = 0; i < tau.size(); ++i) {
    const double share = std::abs(tau[i]) / limits_.torque[i];
    const bool stands = std::abs(arm.dq()[i]) <= limits_.rest_share * limits_.velocity[i];
    const bool too_much = share > 1.0 || (stands && share >= kNearLimit);
    saturated_[i] = too_much ? saturated_[i] + input.dt : 0.0;
    if (saturated_[i] > limits_.torque_seconds) return {SafetyFault::kTorque, {{static_cast<int>(i)}}};
  }
  return {};
}

SafetySupervisor::Finding SafetySupervisor::check_force(const SafetyInput& input) noexcept {
  if (!input.force.allFinite() || !(input.force_age <= limits_.force_age))
    return {SafetyFault::kForceSensor, {}};
  if (input.force.norm() > limits_.force) return {SafetyFault::kForce, {}};
  // The comparison is false if the expected force is NaN.
  const bool disagrees = (input.force - input.force_expected).norm() > limits_.force_disagreement;
  disagreed_ = disagrees ? disagreed_ + input.dt : 0.0;
  if (disagreed_ > limits_.disagreement_seconds) return {SafetyFault::kForceSensor, {}};
  return {};
}

bool SafetySupervisor::is_at_rest(const ArmState& arm) const noexcept {
  return (arm.dq().cwiseAbs().array() <= limits_.rest_share * limits_.velocity.array()).all();
}

// Checks a held arm: its kinetic energy must decrease unless it is at rest. After a force fault the arm yields
// and may move, but must not run away.
SafetySupervisor::Finding SafetySupervisor::check_held(const ArmState& arm,
                                                       const SafetyInput& input) noexcept {
  const bool brakes = action_ == SafetyAction::kHold;
  const bool acts = brakes || action_ == SafetyAction::kRelease;
  for (Eigen::Index i = 0; i < out_.size() && acts && state_ == SafetyState::kFault; ++i) {
    if (std::abs(arm.dq()[i]) > limits_.runaway * limits_.velocity[i])
      return {SafetyFault::kNotHeld, {{static_cast<int>(i)}}};
  }
  if (!brakes && !input.held) {
    watched_ = false;
    return {};
  }
  const double energy = 0.5 * arm.dq().dot(arm.mass_matrix().lazyProduct(arm.dq()));
  slow_for_ += input.dt;
  if (!watched_ || is_at_rest(arm) || energy <= 0.5 * energy_) {
    energy_ = energy;
    slow_for_ = 0.0;
    watched_ = true;
  }
  if (!(slow_for_ > limits_.held_seconds)) return {};
  Eigen::Index fastest = 0;
  arm.dq().cwiseAbs().cwiseQuotient(limits_.velocity).maxCoeff(&fastest);
  return {SafetyFault::kNotHeld, {{static_cast<int>(fastest)}}};
}

SafetySupervisor::Finding SafetySupervisor::check(const ArmState& arm, const SafetyInput& input,
                                                  const VectorRef& tau) noexcept {
  const bool moves = state_ == SafetyState::kActive || state_ == SafetyState::kHoming;
  Finding found = check_sensors(arm, input);
  if (found.fault == SafetyFault::kNone && moves) found = check_motors(arm, input, tau);
  if (found.fault == SafetyFault::kNone && moves) found = check_motion(arm, input);
  if (found.fault == SafetyFault::kNone) found = check_held(arm, input);
  if (found.fault == SafetyFault::kNone) found = check_force(input);
  return found;
}

// Stores a valid state for later cycles that have none.
void SafetySupervisor::store_valid_state(const ArmState& arm, const SafetyInput& input) noexcept {
  q_sound_ = arm.q();
  extra_sound_ = extra_;
  if (input.force.allFinite())
    load_.noalias() = arm.tip().jacobian().topRows<3>().transpose().lazyProduct(input.force);
  momentum_.noalias() = arm.mass_matrix().lazyProduct(arm.dq());
  frozen_for_ = since_sound_ = 0.0;
  seen_ = true;
}

// Limits the holding torque, at a fault, to the uncertainty of the model plus the force at the tip, and
// computes the torque that holds an arm without valid positions.
void SafetySupervisor::keep_holding_torque() noexcept {
  rest_.setZero();
  sound_.update(q_sound_, rest_);
  const VectorXd& u = uncertainty_.update(sound_, rest_);
  for (Eigen::Index i = 0; i < extra_.size(); ++i) {
    const double least = std::min(0.0, load_[i]) - u[i], most = std::max(0.0, load_[i]) + u[i];
    extra_[i] = std::clamp(extra_[i], least, most);
    extra_sound_[i] = std::clamp(extra_sound_[i], least, most);
  }
  frozen_ = gravity_.update(q_sound_) + extra_sound_;
}

// Brakes with -braking dq; once at rest, holds that position.
void SafetySupervisor::brake(const ArmState& arm) noexcept {
  if (!stopped_) {
    stopped_ = is_at_rest(arm);
    q_hold_ = arm.q();
  }
  y_ = kHoldStiffness * (q_hold_ - arm.q()) - limits_.braking * arm.dq();
  out_ = arm.bias() + extra_;
  out_.noalias() += arm.mass_matrix().lazyProduct(y_);
}

void SafetySupervisor::act(const ArmState& arm, const VectorRef& tau, double dt) noexcept {
  switch (action_) {
    case SafetyAction::kMotorsOff:
      out_.setZero();
      break;
    case SafetyAction::kPass:
      out_ = tau;
      break;
    case SafetyAction::kHold:
      brake(arm);
      break;
    case SafetyAction::kRelease:
      // The torque in addition to the model's is omitted, since it may cause the force.
      y_ = -limits_.braking * arm.dq();
      out_ = arm.bias();
      out_.noalias() += arm.mass_matrix().lazyProduct(y_);
      break;
    case SafetyAction::kFreeze:
      out_ = frozen_ -
             kBlindBraking * limits_.braking * std::exp(-limits_.braking * frozen_for_) * momentum_;
      frozen_for_ += std::isfinite(dt) && dt > 0.0 ? dt : 1e-3;
      break;
  }
  for (Eigen::Index i = 0; i < out_.size(); ++i) {
    out_[i] =
        std::isfinite(out_[i]) ? std::clamp(out_[i], -limits_.torque[i], limits_.torque[i]) : 0.0;
  }
}

void SafetySupervisor::record_finding(const Finding& found) noexcept {
  for (int k = 0; k < events_; ++k) {
    if (event_[k].fault == found.fault) return;
  }
  if (events_ < static_cast<int>(event_.size()))
    event_[events_++] = {found.fault, found.joint, fault_for_};
}

const VectorXd& SafetySupervisor::update(const ArmState& arm, const SafetyInput& input,
                                         const VectorRef& tau) noexcept {
  assert(arm.joints() == out_.size() && tau.size() == out_.size());
  if (state_ != SafetyState::kDisabled) {
    // The age of repeated positions grows by one cycle; positions of constant age are new.
    const double newer = input.dt + age_ - input.sensor_age;
    if (std::isfinite(newer)) {
      since_sound_ += newer;
      age_ = input.sensor_age;
    }
    const Finding found = check(arm, input, tau);
    const bool trusted = action_of(found.fault) != SafetyAction::kFreeze;
    if (state_ == SafetyState::kFault && std::isfinite(input.dt)) fault_for_ += input.dt;
    if (found.fault != SafetyFault::kNone) record_finding(found);
    // A force sensor that fails later has no effect, because braking does not use it.
    const bool worse = strength(found.fault) > strength(fault_) &&
                       (fault_ == SafetyFault::kNone || found.fault != SafetyFault::kForceSensor);
    if (worse) {
      fault_ = found.fault;
      joint_ = found.joint;
      state_ = SafetyState::kFault;
      stopped_ = watched_ = false;
      saturated_.setZero();
    }
    // Only new measurements are stored. kFreeze lasts until reset(), since velocities are wrong for some time
    // after a jump.
    const bool fresh = since_sound_ > kNewer * input.dt || !seen_;
    if (trusted && fresh && action_of(fault_) != SafetyAction::kFreeze) store_valid_state(arm, input);
    if (worse) keep_holding_torque();
  }
  switch (state_) {
    case SafetyState::kDisabled:
      action_ = SafetyAction::kMotorsOff;
      break;
    case SafetyState::kHoming:
    case SafetyState::kActive:
      action_ = SafetyAction::kPass;
      break;
    case SafetyState::kReady:
    case SafetyState::kHolding:
      action_ = SafetyAction::kHold;
      break;
    case SafetyState::kFault:
      action_ = seen_ ? action_of(fault_) : SafetyAction::kMotorsOff;
      break;
  }
  act(arm, tau, input.dt);
  return out_;
}

SafetyAction action_of(SafetyFault fault) noexcept {
  switch (fault) {
    case SafetyFault::kNone:
      return SafetyAction::kPass;
    case SafetyFault::kNotFinite:
    case SafetyFault::kSensorAge:
    case SafetyFault::kEncoderJump:
      return SafetyAction::kFreeze;
    case SafetyFault::kForce:
    case SafetyFault::kForceSensor:
      return SafetyAction::kRelease;
    case SafetyFault::kNotHeld:
      return SafetyAction::kMotorsOff;
    case SafetyFault::kController:
    case SafetyFault::kOverrun:
    case SafetyFault::kPosition:
    case SafetyFault::kVelocity:
    case SafetyFault::kTracking:
    case SafetyFault::kTorque:
      break;
  }
  return SafetyAction::kHold;
}

}  // namespace veridyn
