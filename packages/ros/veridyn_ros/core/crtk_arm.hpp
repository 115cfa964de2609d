#pragma once

#include <Eigen/Geometry>
#include <cstdint>

#include "veridyn/control/computed_torque.hpp"
#include "veridyn/control/control_cycle.hpp"
#include "veridyn/control/inverse_kinematics.hpp"
#include "veridyn/control/quintic_interpolator.hpp"
#include "veridyn/control/task_inverse.hpp"

namespace veridyn_ros {

using veridyn::VectorXd;
using veridyn::Vector6d;

constexpr int kMostJoints = 16;

/// A client's command to an arm, by the names of the Collaborative Robotics Toolkit. Plain data of
/// fixed size: commands cross from the network to the loop through a queue without locks.
struct Command {
  enum class Kind {
    kServoJp, kServoJf, kServoCp, kServoCf, kServoCv, kMoveJp, kMoveCp, kHold,
    kEnable, kDisable, kPause, kResume, kHome, kUnhome
  };
  Kind kind = Kind::kHold;
  std::uint64_t client = 0;  ///< identity of the client; two clients cannot stream at once
  double age = 0.0;          ///< [s] by its stamp when it arrived; 0: not stamped
  int count = 0;             ///< entries of `joints`
  double joints[kMostJoints] = {};  ///< [rad], [m], or [N m], [N]
  double position[3] = {};          ///< [m] in the arm's base
  double quaternion[4] = {0, 0, 0, 1};  ///< x, y, z, w
  double six[6] = {};                   ///< wrench or twist at the tip, base axes
};

/// Reason why a command was refused; fixed texts by describe().
enum class Refusal {
  kNone, kNotFinite, kWrongSize, kBeyondLimits, kTooFar, kOutOfReach, kNotEnabled, kNotHomed,
  kOtherClient, kTooOld, kInvalidTransition, kNoPower
};
const char* describe(Refusal refusal) noexcept;

enum class OperatingState { kDisabled, kEnabled, kPaused, kFault };
/// "DISABLED" and so on, as CRTK has it.
const char* name_of(OperatingState state) noexcept;

/// Present mode of the arm.
enum class Mode { kOff, kHold, kServo, kMove, kReleased };
const char* name_of(Mode mode) noexcept;

/// Feedback of an arm at one instant; fixed size, for snapshots without locks.
struct Feedback {
  double time = 0.0;  ///< [s] of the loop's clock
  int joints = 0;
  double q[kMostJoints] = {}, dq[kMostJoints] = {}, tau[kMostJoints] = {};
  double setpoint[kMostJoints] = {};
  double position[3] = {}, quaternion[4] = {0, 0, 0, 1};  ///< of the tip in the base
  double setpoint_position[3] = {}, setpoint_quaternion[4] = {0, 0, 0, 1};
  double twist[6] = {}, wrench[6] = {};  ///< tip, base axes; the wrench from torques beyond gravity
  OperatingState state = OperatingState::kDisabled;
  Mode mode = Mode::kOff;
  bool homed = false, busy = false;
  veridyn::SafetyFault fault = veridyn::SafetyFault::kNone;
  Refusal refusal = Refusal::kNone;  ///< of the last command that was refused
  std::uint64_t refusals = 0;        ///< how many were
  std::uint64_t lost_streams = 0;    ///< streams of commands that fell silent
};

struct CrtkOptions {
  std::string tip;               ///< frame; empty: "tool", or else the last one
  double hold_after = 0.1;       ///< [s] without a command of a stream: hold
  double release_after = 1.0;    ///< [s] after which the arm yields gently
  double oldest = 0.5;           ///< [s] largest age of an accepted command, by its stamp
  double oldest_positions = 0.05;  ///< [s]: beyond, a fault
  double longest_cycle = 0.05;     ///< [s]: beyond, a fault
  double frequency = 5.0;        ///< [Hz] bandwidth of the joint loops, critically damped
  double smoothing = 60.0;       ///< [1/s] of the three lags that setpoints go through
  double observer = 10.0;        ///< [1/s] of the observer of model errors
  double move_velocity = 0.3;    ///< share of the velocity limits in moves
  double velocity = 1.0;         ///< [rad/s], [m/s / 5] where the robot file gives no limit
  double effort = 40.0;          ///< [N m], [N] where the robot file gives no limit
};

/// One arm between clients and motors: arbitration of commands, the operating state of CRTK,
/// computed torque with integral action in the model, the safety supervisor. Knows nothing of ROS,
/// allocates nothing and throws nothing after the constructor; one object serves one thread.
///
/// - A stream (servo_*) that falls silent for `hold_after` is held where it got to, one that stays
///   silent for `release_after` gives way: gravity and damping alone. The next command takes over
///   from where the arm then is. Moves and hold end in holding for ever.
/// - Commands that are not finite, beyond limits, farther than the velocity limits allow, older than
///   `oldest`, or from another client than the one that streams, are refused; the arm goes on with
///   what it did.
/// - Setpoints go through three lags of 1 / smoothing each: a stream at 50 Hz makes no steps. Streams
///   of positions are followed at 0.8 of the velocity limits at most: bursts of messages do no harm.
/// - servo_jf and servo_cf come on top of gravity compensation.
///
///   CrtkArm arm(model);
///   every cycle: while (queue.pop(c)) arm.command(c);  tau = arm.update(q, dq, age, 0.001);
class CrtkArm {
 public:
  /// @throws veridyn::InvalidInput  as the controllers; more than kMostJoints joints.
  explicit CrtkArm(const veridyn::Model& model, const CrtkOptions& options = {});

  /// @returns why it was refused, or kNone.
  Refusal command(const Command& command) noexcept;

  /// Clients see and ask for true positions and torques; what the model knows of its sensors
  /// (veridyn::JointSensors) is undone here.
  ///
  /// @param shown_q, dq  (n) as the encoders show them. @param age [s] of them. @param dt [s] since the last update(), as
  /// it was by a steady clock. @param powered  false: torques have no effect yet; the setpoint stays
  /// with the arm, which is busy, and motions are refused. @returns (n) torques as drives count them, always finite and within limits.
  const VectorXd& update(const VectorXd& shown_q, const VectorXd& dq, double age, double dt,
                         bool powered = true) noexcept;

  const Feedback& feedback() const { return feedback_; }
  int joints() const { return n_; }
  const veridyn::Model& model() const { return model_; }
  OperatingState state() const { return state_; }
  Mode mode() const { return mode_; }

 private:
  Refusal refusal_of(const Command& c) noexcept;
  Refusal transition(Command::Kind kind) noexcept;
  Refusal accept_joints(const Command& c, bool move) noexcept;
  Refusal accept_pose(const Command& c, bool move) noexcept;
  Refusal accept_effort(const Command& c) noexcept;
  Refusal accept_twist(const Command& c) noexcept;
  bool is_within_limits(const VectorXd& q) const noexcept;
  void hold() noexcept;
  void watch_silence(double dt) noexcept;
  void follow_twist(double dt) noexcept;
  void follow_joints(double dt) noexcept;
  void smooth(double dt) noexcept;
  void hold_position() noexcept;
  void publish_state() noexcept;

  veridyn::Model model_;
  CrtkOptions options_;
  int n_;
  veridyn::Tip tip_;
  veridyn::ControlCycle cycle_;
  veridyn::ComputedTorque control_;
  veridyn::InverseKinematics inverse_;
  veridyn::TaskInverse task_;
  veridyn::TipKinematics setpoint_;
  veridyn::QuinticInterpolator way_;
  veridyn::JointReference wanted_;
  veridyn::SafetyLimits limits_;
  veridyn::Measured measured_;
  VectorXd goal_, effort_, tau_, zero_, speed_, led_, smoothed_;
  Vector6d twist_{Vector6d::Zero()};
  OperatingState state_ = OperatingState::kDisabled;
  Mode mode_ = Mode::kOff;
  Command::Kind stream_ = Command::Kind::kHold;
  std::uint64_t client_ = 0;
  double silent_ = 0.0, now_ = 0.0;
  bool seen_ = false, homed_ = true, powered_ = true;
  Feedback feedback_;
};

}  // namespace veridyn_ros
