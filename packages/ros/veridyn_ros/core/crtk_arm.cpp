#include "core/crtk_arm.hpp"

#include <algorithm>
#include <cmath>

#include "veridyn/math/require.hpp"

namespace veridyn_ros {
namespace {

using namespace veridyn;
using Kind = Command::Kind;

constexpr double kTwoPi = 6.283185307179586;
constexpr double kServoSpeed = 0.8;      // largest share of the velocity limits in streams of positions
constexpr double kStop = 0.1;            // [s] duration of the braking of a move
constexpr double kSliding = 0.2;         // [m/rad] default velocity limit of prismatic over revolute joints

// The named frame; without a name "tool", or else the last frame.
Tip tip_of(const Model& arm, const std::string& name) {
  if (!name.empty()) return {name};
  return {arm.find_frame("tool") ? "tool" : arm.frames().back().name};
}

TaskRows rows_of(const Model& arm) {
  return arm.joints() >= 6 ? TaskRows::kPose : TaskRows::kPosition;
}

// Critically damped gains of this bandwidth [Hz].
JointGains gains_of(const Model& arm, double frequency) {
  const double w = kTwoPi * frequency;
  return {VectorXd::Constant(arm.joints(), w * w), VectorXd::Constant(arm.joints(), 2.0 * w)};
}

// Limits of the robot file, with the options where it gives none.
SafetyLimits limits_of(const Model& arm, const CrtkOptions& o) {
  SafetyLimits limits = safety_limits(arm, o.effort);
  for (int i = 0; i < arm.joints(); ++i) {
    const bool slides = arm.coordinates()[i].prismatic;
    if (!std::isfinite(limits.velocity[i]) || limits.velocity[i] <= 0.0)
      limits.velocity[i] = o.velocity * (slides ? kSliding : 1.0);
  }
  limits.tracking.setConstant(1e9);  // clients set the reference; targets that are too far are refused
  limits.force = 1e9;
  limits.overrun = o.longest_cycle;
  limits.sensor_age = o.oldest_positions;
  return limits;
}

CycleOptions cycle_of(const Model& arm, const CrtkOptions& o) {
  CycleOptions out;
  out.friction.share = 0.0;
  out.error_bandwidth = o.observer;
  out.error_limit = 0.25 * safety_limits(arm, o.effort).torque;
  out.limits = limits_of(arm, o);
  return out;
}

InverseKinematicsOptions inverse_of(const Model& arm) {
  InverseKinematicsOptions o;
  o.rows = rows_of(arm);
  o.position_tolerance = 1e-5;
  o.angle_tolerance = 1e-4;
  return o;
}

// Writes the rotation as x, y, z, w.
void copy_quaternion(const Eigen::Matrix3d& R, double (&out)[4]) {
  const Eigen::Quaterniond q(R);
  out[0] = q.x();
  out[1] = q.y();
  out[2] = q.z();
  out[3] = q.w();
}

}  // namespace

CrtkArm::CrtkArm(const Model& model, const CrtkOptions& options)
    : model_(model), options_(options), n_(model.joints()), tip_(tip_of(model, options.tip)),
      cycle_(model, tip_, cycle_of(model, options)), control_(n_, gains_of(model, options.frequency)),
      inverse_(model, tip_, inverse_of(model)), task_(model, tip_, rows_of(model)),
      setpoint_(model, tip_), setpoint_path_(VectorXd::Zero(n_)), reference_(n_), limits_(cycle_.limits()), measured_(n_),
      goal_(VectorXd::Zero(n_)), effort_(goal_), tau_(goal_), zero_(goal_), speed_(goal_), stream_target_(goal_),
      smoothed_(goal_) {
  require(n_ <= kMostJoints, "veridyn_ros: found ", n_, " joints, expected at most ", kMostJoints, ".");
  require(options.oldest_positions > 0.0 && options.longest_cycle > 0.0,
          "veridyn_ros: expected oldest_positions and longest_cycle above zero.");
  require(options.hold_after > 0.0 && options.release_after > options.hold_after,
          "veridyn_ros: expected 0 < hold_after < release_after.");
  feedback_.joints = n_;
  measured_.dq = zero_;
  cycle_.disable();
}

// Ends the motion: a stream of positions and a move stop at the setpoint, other modes at the measured position.
void CrtkArm::hold() noexcept {
  const bool led = mode_ == Mode::kServo && stream_ != Kind::kServoJf && stream_ != Kind::kServoCf;
  if (led) {
    setpoint_path_.reset(setpoint_path_.x());
  } else if (mode_ == Mode::kMove) {
    setpoint_path_.stop(kStop);
  } else if (mode_ != Mode::kHold) {
    goal_ = cycle_.state().q().cwiseMax(limits_.lower).cwiseMin(limits_.upper);
    setpoint_path_.reset(goal_);
    hold_position();
  }
  mode_ = Mode::kHold;
  silence_ = 0.0;
}

// Holds after a stream of commands has ended, and releases the arm later; `dt` [s] since the last cycle.
void CrtkArm::watch_silence(double dt) noexcept {
  silence_ += dt;
  if (mode_ == Mode::kServo && silence_ > options_.hold_after) {
    hold();
    silence_ = options_.hold_after;
    stream_ = Kind::kServoJp;
    ++feedback_.lost_streams;
    client_ = 0;
    return;
  }
  // Held because a stream ended, not by a hold command.
  const bool lost = mode_ == Mode::kHold && stream_ != Kind::kHold;
  if (lost && silence_ > options_.release_after) mode_ = Mode::kReleased;
  if (mode_ == Mode::kMove && setpoint_path_.arrived()) {
    mode_ = Mode::kHold;
    stream_ = Kind::kHold;
  }
}

// Moves the setpoint by the commanded twist over `dt` [s], within the joints' limits.
void CrtkArm::follow_twist(double dt) noexcept {
  setpoint_.update(setpoint_path_.x(), zero_);
  task_.update(setpoint_.jacobian());
  task_.solve(twist_, zero_, speed_);
  goal_ = (setpoint_path_.x() + dt * speed_).cwiseMax(limits_.lower).cwiseMin(limits_.upper);
  setpoint_path_.reset(goal_);
}

// Moves the setpoint toward the stream's, within the velocity limits, because messages arrive in bursts.
void CrtkArm::follow_joints(double dt) noexcept {
  for (int i = 0; i < n_; ++i) {
    const double most = kServoSpeed * limits_.velocity[i] * dt;
    goal_[i] = setpoint_path_.x()[i] + std::clamp(stream_target_[i] - setpoint_path_.x()[i], -most, most);
  }
  setpoint_path_.reset(goal_);
}

// Sets the controller's reference to the arm's position, at rest.
void CrtkArm::hold_position() noexcept {
  smoothed_ = goal_;
  reference_.q = goal_;
  reference_.dq.setZero();
  reference_.ddq.setZero();
}

// Three first-order lags: one on the setpoint, two on the reference, which also give its velocity and
// acceleration.
void CrtkArm::smooth(double dt) noexcept {
  const double w = options_.smoothing;
  smoothed_ += (1.0 - std::exp(-w * dt)) * (setpoint_path_.x() - smoothed_);
  reference_.ddq = w * w * (smoothed_ - reference_.q) - 2.0 * w * reference_.dq;
  reference_.dq += dt * reference_.ddq;
  reference_.q += dt * reference_.dq;
}

const VectorXd& CrtkArm::update(const VectorXd& shown_q, const VectorXd& dq, double age,
                                double dt, bool powered) noexcept {
  measured_.q = shown_q;
  measured_.dq = dq;
  measured_.age = age;
  const ArmState& arm = cycle_.measure(measured_, dt);
  const VectorXd& q = arm.q();
  now_ += dt;
  powered_ = powered;
  if (!seen_ && q.allFinite()) {
    setpoint_path_.reset(q);
    goal_ = q;
    hold_position();
    seen_ = true;
  }
  watch_silence(dt);
  if (!powered_ && q.allFinite()) {
    goal_ = q;
    setpoint_path_.reset(goal_);
    hold_position();
    if (mode_ != Mode::kOff) mode_ = Mode::kHold;
    stream_ = Kind::kHold;
  }
  if (mode_ == Mode::kServo && stream_ == Kind::kServoCv) follow_twist(dt);
  if (mode_ == Mode::kServo && (stream_ == Kind::kServoJp || stream_ == Kind::kServoCp)) follow_joints(dt);
  setpoint_path_.advance(dt);
  const bool by_effort =
      mode_ == Mode::kServo && (stream_ == Kind::kServoJf || stream_ == Kind::kServoCf);
  if (by_effort) {
    tau_ = arm.bias() + effort_;
    cycle_.command(tau_);
  } else if (mode_ == Mode::kReleased) {
    cycle_.command_gravity_compensation();
  } else {
    smooth(dt);
    cycle_.command(control_.update(arm, reference_));
    if (powered_) cycle_.add_model_error(control_.acceleration());
  }
  const VectorXd& drive = cycle_.send();
  if (cycle_.fault() && state_ != OperatingState::kFault && state_ != OperatingState::kDisabled) {
    state_ = OperatingState::kFault;
    mode_ = Mode::kHold;
  }
  if (state_ == OperatingState::kDisabled || state_ == OperatingState::kFault) {
    goal_ = q.allFinite() ? q : goal_;
    setpoint_path_.reset(goal_);
    hold_position();
  }
  fill_feedback();
  return drive;
}

// Fills feedback() with the present state.
void CrtkArm::fill_feedback() noexcept {
  Feedback& f = feedback_;
  f.time = now_;
  setpoint_.update(setpoint_path_.x(), setpoint_path_.dx());
  const ArmState& arm = cycle_.state();
  const TipKinematics& tip = arm.tip();
  tau_ = cycle_.torque() - arm.bias();  // torque beyond gravity
  if (state_ == OperatingState::kDisabled || !powered_) tau_.setZero();  // brakes carry it
  Vector6d wrench = Vector6d::Zero();
  task_.update(tip.jacobian());
  task_.solve_wrench(tau_, wrench);
  for (int i = 0; i < n_; ++i) {
    f.q[i] = arm.q()[i];
    f.dq[i] = arm.dq()[i];
    f.tau[i] = cycle_.torque()[i];
    f.setpoint[i] = setpoint_path_.x()[i];
  }
  for (int i = 0; i < 3; ++i) {
    f.position[i] = tip.position()[i];
    f.setpoint_position[i] = setpoint_.position()[i];
  }
  for (int i = 0; i < 6; ++i) {
    f.twist[i] = tip.twist()[i];
    f.wrench[i] = wrench[i];
  }
  copy_quaternion(tip.rotation(), f.quaternion);
  copy_quaternion(setpoint_.rotation(), f.setpoint_quaternion);
  f.state = state_;
  f.mode = mode_;
  f.homed = homed_;
  f.busy = mode_ == Mode::kMove || (!powered_ && state_ == OperatingState::kEnabled);
  const std::optional<ControllerFault> fault = cycle_.fault();
  f.fault = fault ? fault->what : SafetyFault::kNone;
}

}  // namespace veridyn_ros
