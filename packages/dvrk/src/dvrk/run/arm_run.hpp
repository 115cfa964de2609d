#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "dvrk/run/arm_session.hpp"
#include "dvrk/run/loop_timing.hpp"
#include "dvrk/run/controllers/motion_controller.hpp"
#include "veridyn/math/motion_samples.hpp"
#include "veridyn/recordings/recording.hpp"
#include "veridyn/simulation/control_loop.hpp"

namespace veridyn::dvrk {

struct RunOptions {
  double rate = 1500.0;          ///< [Hz] rate of the cycle
  double approach_time = 2.0;    ///< [s] shortest duration of the motion to the first set point
  double approach_speed = 0.25;  ///< [rad/s] or [m/s] largest speed of the approach
  double settle = 0.5;           ///< [s] duration of the rest before and after the motion
  /// Tracking error at which a joint ends the run: (n) of the arm, each in its own unit; empty:
  /// those of default_largest_errors().
  VectorXd largest_error;
  double power_timeout = 5.0;  ///< [s] within which power must be up
  std::string recording;       ///< file written during the run; empty: none
};

struct RunResult {
  Recording rows;  ///< t, q, dq, tau of the motion itself; t by the boards' clock, 0 at its first row
  bool complete = false;
  std::string why;  ///< reason for an early end
  std::string remark;  ///< remark for readers of the recording, complete or not
  LoopTiming timing;
  /// Status of the boards after switching off.
  OffState power = OffState::kNotAsked;
  Eigen::Index kept = 0;   ///< rows in RunOptions::recording
  std::string file_error;  ///< reason if these are not all rows
};

/// Largest error of every joint from its set point: 0.35 rad, or 0.02 m where it slides.
VectorXd default_largest_errors(const RobotConfig& robot);

/// Powers an arm up, moves it along a motion with a PID per joint, records the boards' readings,
/// and powers it down in any case, also after an exception (the session's destructor). Joints
/// beyond those of the motion hold their position.
///
/// Before power-up, the whole motion and the arm's position are tested against the soft limits of the
/// actuators and the limits of the controller, with the same test (leaves_range()) as during the run. A loop
/// with less than half of its cycles for half a second ends the run; if the mean rate is below 95 %, complete
/// is false.
///
/// @param motion  rows of q and dq; between them a cubic.
/// @param gains   one per joint of the arm.
/// @param stop    set by a signal: ends the run with power off.
/// @throws InvalidInput  sizes that do not fit, set points beyond soft limits; the session does not
///                       start.
RunResult run_motion(ArmSession& arm, DatagramLink& link, const MotionSamples& motion,
                     const PidGains& gains, const RunOptions& options,
                     const std::atomic<bool>& stop);

/// The same with any controller. @throws InvalidInput  as above, and as
/// MotionController::require_possible().
RunResult run_motion(ArmSession& arm, DatagramLink& link, const MotionSamples& motion,
                     MotionController& controller, const RunOptions& options,
                     const std::atomic<bool>& stop);

/// Lets a controller without set points act for a time, for example ControlLaw::kGravity, and records the
/// first `joints`; the set point of every joint is its position at power-up.
/// @throws InvalidInput  a time that is not positive, joints that do not exist; the session does not start.
RunResult run_in_place(ArmSession& arm, DatagramLink& link, double seconds, int joints,
                       MotionController& controller, const RunOptions& options,
                       const std::atomic<bool>& stop);

/// The largest torque of each joint [N m], [N] by the motors' largest currents, (n).
VectorXd largest_torques(const ArmSession& arm);

/// Reads for a time without power, and calls `each` with the time [s] after every valid read. With
/// ArmSessionOptions::access other than kDrive no packet changes a board.
/// @throws InvalidInput  the session does not start.
LoopTiming watch(ArmSession& arm, DatagramLink& link, double seconds, double rate,
                 const std::atomic<bool>& stop, const std::function<void(double)>& each);

/// Records without moving, optionally also to a file (empty: none). Encoders that fail meanwhile are reported
/// in RunResult::remark and in the file. @throws InvalidInput  the session does not start.
RunResult record_at_rest(ArmSession& arm, DatagramLink& link, double seconds, double rate,
                         const std::atomic<bool>& stop, const std::string& recording = "");

}  // namespace veridyn::dvrk
