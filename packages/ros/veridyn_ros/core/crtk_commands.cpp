#include <algorithm>
#include <cmath>

#include "core/crtk_arm.hpp"

// Commands of clients, and the reasons for refusals.

namespace veridyn_ros {
namespace {

using namespace veridyn;
using Kind = Command::Kind;

constexpr double kReach = 0.1;  // [s] duration at the velocity limit: a farther setpoint is refused
constexpr double kLeastMove = 0.2;    // [s] shortest duration of a move
constexpr double kAccelerate = 0.25;  // [s] time to reach the velocity of a move

bool is_stream(Kind kind) {
  return kind == Kind::kServoJp || kind == Kind::kServoJf || kind == Kind::kServoCp ||
         kind == Kind::kServoCf || kind == Kind::kServoCv;
}

bool is_motion(Kind kind) { return is_stream(kind) || kind == Kind::kMoveJp || kind == Kind::kMoveCp; }

bool needs_joints(Kind kind) {
  return kind == Kind::kServoJp || kind == Kind::kServoJf || kind == Kind::kMoveJp;
}

bool is_finite(const Command& c) {
  const auto all = [](const double* x, int count) {
    return std::all_of(x, x + count, [](double v) { return std::isfinite(v); });
  };
  return std::isfinite(c.age) && all(c.joints, std::clamp(c.count, 0, kMostJoints)) &&
         all(c.position, 3) && all(c.quaternion, 4) && all(c.six, 6);
}

}  // namespace

const char* describe(Refusal refusal) noexcept {
  switch (refusal) {
    case Refusal::kNone: return "taken";
    case Refusal::kNotFinite: return "a number is not finite";
    case Refusal::kWrongSize: return "another number of joints than the arm has";
    case Refusal::kBeyondLimits: return "beyond the joints' limits";
    case Refusal::kTooFar: return "farther from the setpoint than the velocity limits allow";
    case Refusal::kOutOfReach: return "no joints put the tip there";
    case Refusal::kNotEnabled: return "the arm is not ENABLED";
    case Refusal::kNotHomed: return "the arm is not homed";
    case Refusal::kOtherClient: return "another client is commanding the arm";
    case Refusal::kTooOld: return "its stamp is too old, or lies in the future";
    case Refusal::kNoPower: return "the motors have no power yet";
    case Refusal::kInvalidTransition: return "not allowed in this operating state";
  }
  return "";
}

const char* name_of(OperatingState state) noexcept {
  switch (state) {
    case OperatingState::kDisabled: return "DISABLED";
    case OperatingState::kEnabled: return "ENABLED";
    case OperatingState::kPaused: return "PAUSED";
    case OperatingState::kFault: return "FAULT";
  }
  return "";
}

const char* name_of(Mode mode) noexcept {
  switch (mode) {
    case Mode::kOff: return "off";
    case Mode::kHold: return "hold";
    case Mode::kServo: return "servo";
    case Mode::kMove: return "move";
    case Mode::kReleased: return "released";
  }
  return "";
}

bool CrtkArm::is_within_limits(const VectorXd& q) const noexcept {
  return (q.array() >= limits_.lower.array()).all() && (q.array() <= limits_.upper.array()).all();
}

Refusal CrtkArm::command(const Command& c) noexcept {
  const Refusal why = execute_or_refuse(c);
  if (why == Refusal::kNone) {
    if (is_stream(c.kind)) {
      stream_ = c.kind;
      client_ = c.client;
      silence_ = 0.0;
      mode_ = Mode::kServo;
    }
    return why;
  }
  feedback_.refusal = why;
  ++feedback_.refusals;
  return why;
}

// Executes the command if it is allowed; else returns the reason.
Refusal CrtkArm::execute_or_refuse(const Command& c) noexcept {
  if (!is_finite(c)) return Refusal::kNotFinite;
  if (std::abs(c.age) > options_.oldest) return Refusal::kTooOld;
  // Commands that reduce motion are always accepted.
  if (c.kind == Kind::kDisable || c.kind == Kind::kPause || c.kind == Kind::kEnable ||
      c.kind == Kind::kResume || c.kind == Kind::kHome || c.kind == Kind::kUnhome)
    return change_state(c.kind);
  if (state_ != OperatingState::kEnabled) return Refusal::kNotEnabled;
  if (!homed_) return Refusal::kNotHomed;
  if (c.kind == Kind::kHold) {
    hold();
    return Refusal::kNone;
  }
  if (!powered_) return Refusal::kNoPower;
  if (is_motion(c.kind) && mode_ == Mode::kServo && c.client != client_ && silence_ < options_.hold_after)
    return Refusal::kOtherClient;
  if (needs_joints(c.kind) && c.count != n_) return Refusal::kWrongSize;
  if (mode_ == Mode::kReleased) hold();  // motion starts from the present position of the arm
  switch (c.kind) {
    case Kind::kServoJp: return accept_joints(c, false);
    case Kind::kMoveJp: return accept_joints(c, true);
    case Kind::kServoCp: return accept_pose(c, false);
    case Kind::kMoveCp: return accept_pose(c, true);
    case Kind::kServoJf:
    case Kind::kServoCf: return accept_effort(c);
    case Kind::kServoCv: return accept_twist(c);
    default: return Refusal::kInvalidTransition;
  }
}

// Changes the operating state by CRTK's rules; kInvalidTransition where they do not allow it.
Refusal CrtkArm::change_state(Kind kind) noexcept {
  const auto now = state_;
  const auto to = [this](OperatingState state) {
    state_ = state;
    return Refusal::kNone;
  };
  switch (kind) {
    case Kind::kEnable:
      if (now == OperatingState::kPaused || !seen_) return Refusal::kInvalidTransition;
      if (now == OperatingState::kEnabled) return Refusal::kNone;
      cycle_.reset();
      hold();
      return to(OperatingState::kEnabled);
    case Kind::kDisable:
      cycle_.disable();
      mode_ = Mode::kOff;
      return to(OperatingState::kDisabled);
    case Kind::kPause:
      if (now != OperatingState::kEnabled && now != OperatingState::kPaused)
        return Refusal::kInvalidTransition;
      if (now == OperatingState::kEnabled) hold();
      return to(OperatingState::kPaused);
    case Kind::kResume:
      return now == OperatingState::kPaused ? to(OperatingState::kEnabled)
                                            : Refusal::kInvalidTransition;
    case Kind::kHome:  // nothing to search for: positions are absolute
      if (now != OperatingState::kEnabled) return Refusal::kInvalidTransition;
      homed_ = true;
      return Refusal::kNone;
    default:
      homed_ = false;
      if (now == OperatingState::kEnabled) hold();
      return Refusal::kNone;
  }
}

// Sets the stream's joint positions, or plans a move to them.
Refusal CrtkArm::accept_joints(const Command& c, bool move) noexcept {
  for (int i = 0; i < n_; ++i) goal_[i] = c.joints[i];
  if (!is_within_limits(goal_)) return Refusal::kBeyondLimits;
  double seconds = kLeastMove;
  for (int i = 0; i < n_; ++i) {
    const double way = std::abs(goal_[i] - setpoint_path_.x()[i]);
    if (!move && way > kReach * limits_.velocity[i]) return Refusal::kTooFar;
    const double speed = options_.move_velocity * limits_.velocity[i];
    seconds = std::max(seconds, QuinticInterpolator::duration_for(way, speed, speed / kAccelerate));
  }
  if (mode_ == Mode::kServo && (stream_ == Kind::kServoJf || stream_ == Kind::kServoCf)) {
    hold();
    if (!move) {
      for (int i = 0; i < n_; ++i)
        if (std::abs(goal_[i] - setpoint_path_.x()[i]) > kReach * limits_.velocity[i]) return Refusal::kTooFar;
    }
  }
  if (move) {
    setpoint_path_.move_to(goal_, seconds);
    mode_ = Mode::kMove;
  } else {
    stream_target_ = goal_;
  }
  return Refusal::kNone;
}

// The same for a pose of the tip, by inverse kinematics.
Refusal CrtkArm::accept_pose(const Command& c, bool move) noexcept {
  Eigen::Quaterniond turn(c.quaternion[3], c.quaternion[0], c.quaternion[1], c.quaternion[2]);
  if (!(turn.norm() > 0.5 && turn.norm() < 2.0)) return Refusal::kNotFinite;
  turn.normalize();
  effort_ = setpoint_path_.x();  // initial guess of the search
  const Eigen::Vector3d position(c.position[0], c.position[1], c.position[2]);
  if (inverse_.solve(position, turn.toRotationMatrix(), effort_) != ReachStatus::kReached)
    return Refusal::kOutOfReach;
  Command joints = c;
  joints.count = n_;
  for (int i = 0; i < n_; ++i) joints.joints[i] = effort_[i];
  return accept_joints(joints, move);
}

// Sets joint torques, for servo_cf those of the wrench; refuses torques beyond the limits.
Refusal CrtkArm::accept_effort(const Command& c) noexcept {
  for (int i = 0; i < n_; ++i) tau_[i] = c.joints[i];
  if (c.kind == Kind::kServoCf) {
    const Eigen::Map<const Vector6d> wrench(c.six);
    tau_.noalias() = cycle_.state().tip().jacobian().transpose() * wrench;
  }
  for (int i = 0; i < n_; ++i)
    if (std::abs(tau_[i]) > limits_.torque[i]) return Refusal::kBeyondLimits;
  effort_ = tau_;
  return Refusal::kNone;
}

// Sets the twist of the tip; refuses joint velocities beyond the limits.
Refusal CrtkArm::accept_twist(const Command& c) noexcept {
  const Eigen::Map<const Vector6d> twist(c.six);
  setpoint_.update(setpoint_path_.x(), zero_);
  task_.update(setpoint_.jacobian());
  task_.solve(twist, zero_, speed_);
  for (int i = 0; i < n_; ++i)
    if (std::abs(speed_[i]) > limits_.velocity[i]) return Refusal::kBeyondLimits;
  twist_ = twist;
  return Refusal::kNone;
}

}  // namespace veridyn_ros
