#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "veridyn/dvrk/arm_session.hpp"
#include "veridyn/dvrk/motion_controller.hpp"
#include "veridyn/recordings/recording.hpp"
#include "veridyn/math/motion_samples.hpp"
#include "veridyn/simulation/control_loop.hpp"

namespace veridyn::dvrk {

struct RunOptions {
  double rate = 1500.0;          ///< [Hz] of the cycle
  double approach_time = 2.0;    ///< [s] at least, to the first set point
  double approach_speed = 0.25;  ///< [rad/s] or [m/s] at most on that way
  double settle = 0.5;           ///< [s] at rest before and after the motion
  double largest_error = 0.35;   ///< [rad] or [m]; further off a set point the run stops
  double power_timeout = 5.0;    ///< [s] in which power must be up
};

/// How well the loop kept its time.
struct LoopTiming {
  long cycles = 0;
  long late = 0;         ///< cycles that began more than one period after their time
  double longest = 0.0;  ///< [s] from the start of one cycle to its end
  double mean = 0.0;
};

struct RunResult {
  Recording rows;  ///< t, q, dq, tau of the motion itself; t from the boards, 0 at its first row
  bool complete = false;
  std::string why;  ///< what ended it, where it is not complete
  LoopTiming timing;
};

/// Powers an arm up, leads it along a motion with a PID per joint, records what the boards say, and
/// powers it down: on every way out, exceptions included (the session's destructor). Joints beyond
/// those of the motion hold where they stand.
///
/// @param motion  rows of q and dq; between them a cubic.
/// @param gains   one per joint of the arm.
/// @param stop    set by a signal: ends the run with power off.
/// @throws InvalidInput  sizes that do not fit, set points beyond soft limits; the session does not
///                       start.
RunResult run_motion(ArmSession& arm, DatagramLink& link, const MotionSamples& motion,
                     const PidGains& gains, const RunOptions& options,
                     const std::atomic<bool>& stop);

/// The same with any controller.
/// @throws InvalidInput  as above, and as MotionController::require_possible().
RunResult run_motion(ArmSession& arm, DatagramLink& link, const MotionSamples& motion,
                     MotionController& controller, const RunOptions& options,
                     const std::atomic<bool>& stop);

/// Lets a controller without set points act for so long, for example ControlLaw::kGravity, and
/// records the first `joints`; the set point of every joint is where it stood when power came up.
/// @throws InvalidInput  a time that is not positive, joints that are not there; the session does
///                       not start.
RunResult run_in_place(ArmSession& arm, DatagramLink& link, double seconds, int joints,
                       MotionController& controller, const RunOptions& options,
                       const std::atomic<bool>& stop);

/// The largest torque of each joint [N m], [N] by the motors' largest currents, (n).
VectorXd largest_torques(const ArmSession& arm);

/// Reads for so long without power, and calls `each` with the time [s] after every valid read.
/// @throws InvalidInput  the session does not start.
LoopTiming watch(ArmSession& arm, DatagramLink& link, double seconds, double rate,
                 const std::atomic<bool>& stop, const std::function<void(double)>& each);

/// The same, and records. @throws InvalidInput  the session does not start.
RunResult record_at_rest(ArmSession& arm, DatagramLink& link, double seconds, double rate,
                         const std::atomic<bool>& stop);

}  // namespace veridyn::dvrk
