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
  double age = 0.0;          ///< [s] difference of its stamp and its arrival; 0: no stamp
  int count = 0;             ///< entries of `joints`
  double joints[kMostJoints] = {};  ///< [rad], [m], or [N m], [N]
  double position[3] = {};          ///< [m] position in the arm's base
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
  double time = 0.0;  ///< [s] time of the loop's clock
  int joints = 0;
  double q[kMostJoints] = {}, dq[kMostJoints] = {}, tau[kMostJoints] = {};
  double setpoint[kMostJoints] = {};
  double position[3] = {}, quaternion[4] = {0, 0, 0, 1};  ///< [m] position and orientation of the tip in the base
  double setpoint_position[3] = {}, setpoint_quaternion[4] = {0, 0, 0, 1};
  double twist[6] = {}, wrench[6] = {};  ///< tip, base axes; the wrench from torques beyond gravity
  OperatingState state = OperatingState::kDisabled;
  Mode mode = Mode::kOff;
  bool homed = false, busy = false;
  veridyn::SafetyFault fault = veridyn::SafetyFault::kNone;
  Refusal refusal = Refusal::kNone;  ///< reason of the last refusal
  std::uint64_t refusals = 0;        ///< number of refused commands
  std::uint64_t lost_streams = 0;    ///< number of streams of commands that ended without notice
};

struct CrtkOptions {
  std::string tip;               ///< frame; empty: "tool", or else the last one
  double hold_after = 0.1;       ///< [s] gap in a stream of commands after which the arm holds
  double release_after = 1.0;    ///< [s] time without a command after which the arm is released (see below)
  double oldest = 0.5;           ///< [s] largest age of a command, by its stamp; older ones are refused
  double oldest_positions = 0.05;  ///< [s] largest age of positions; older ones are a fault
  double longest_cycle = 0.05;     ///< [s] longest cycle; a longer one is a fault
  double frequency = 5.0;        ///< [Hz] bandwidth of the joint loops, critically damped
  double smoothing = 60.0;       ///< [1/s] bandwidth of each of the three lags of setpoints
  double observer = 10.0;        ///< [1/s] bandwidth of the observer of model errors
  double move_velocity = 0.3;    ///< share of the velocity limits in moves
  double velocity = 1.0;         ///< [rad/s], [m/s / 5] where the robot file gives no limit
  double effort = 40.0;          ///< [N m], [N] where the robot file gives no limit
};

/// One arm between clients and motors: accepts or refuses commands, keeps the operating state of CRTK, and
/// runs computed torque with an integral action and a safety supervisor. It does not depend on ROS; nothing
/// allocates or throws after the constructor; one object serves one thread.
///
/// - If a stream (servo_*) ends, the arm holds after `hold_after` seconds, and after `release_after` is
///   released: gravity compensation and damping alone. The next command starts from the arm's position then. A
///   move ends in a hold.
/// - Commands that are not finite, beyond limits, farther than the velocity limits allow, older than
///   `oldest`, or from another client than the one that streams, are refused; the arm continues as before.
/// - Setpoints pass three lags of 1 / smoothing each, so that a stream at 50 Hz causes no steps. Streams of
///   positions move the arm at 0.8 of the velocity limits at most, so that bursts of messages are harmless.
/// - servo_jf and servo_cf are added to gravity compensation.
///
///   CrtkArm arm(model);
///   every cycle: while (queue.pop(c)) arm.command(c);  tau = arm.update(q, dq, age, 0.001);
class CrtkArm {
 public:
  /// @throws veridyn::InvalidInput  as the controllers; more than kMostJoints joints.
  explicit CrtkArm(const veridyn::Model& model, const CrtkOptions& options = {});

  /// Executes a command, or refuses it without effect. @returns the reason for a refusal, or kNone.
  Refusal command(const Command& command) noexcept;

  /// Clients use true positions and torques; the errors of the model's sensors (veridyn::JointSensors) are
  /// undone here.
  ///
  /// @param shown_q, dq  (n) as measured by the encoders. @param age [s] of them. @param dt [s] since the
  /// last update(), by a steady clock. @param powered  false: torques have no effect yet; the setpoint
  /// follows the arm, which is busy, and motions are refused. @returns (n) torques in the drives' scale,
  /// always finite and within limits.
  const VectorXd& update(const VectorXd& shown_q, const VectorXd& dq, double age, double dt,
                         bool powered = true) noexcept;

  const Feedback& feedback() const { return feedback_; }
  int joints() const { return n_; }
  const veridyn::Model& model() const { return model_; }
  OperatingState state() const { return state_; }
  Mode mode() const { return mode_; }

 private:
  Refusal execute_or_refuse(const Command& c) noexcept;
  Refusal change_state(Command::Kind kind) noexcept;
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
  void fill_feedback() noexcept;

  veridyn::Model model_;
  CrtkOptions options_;
  int n_;
  veridyn::Tip tip_;
  veridyn::ControlCycle cycle_;
  veridyn::ComputedTorque control_;
  veridyn::InverseKinematics inverse_;
  veridyn::TaskInverse task_;
  veridyn::TipKinematics setpoint_;
  veridyn::QuinticInterpolator setpoint_path_;
  veridyn::JointReference reference_;
  veridyn::SafetyLimits limits_;
  veridyn::Measured measured_;
  VectorXd goal_, effort_, tau_, zero_, speed_, stream_target_, smoothed_;
  Vector6d twist_{Vector6d::Zero()};
  OperatingState state_ = OperatingState::kDisabled;
  Mode mode_ = Mode::kOff;
  Command::Kind stream_ = Command::Kind::kHold;
  std::uint64_t client_ = 0;
  double silence_ = 0.0, now_ = 0.0;
  bool seen_ = false, homed_ = true, powered_ = true;
  Feedback feedback_;
};

}  // namespace veridyn_ros
