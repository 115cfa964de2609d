#pragma once

#include <memory>

#include "core/crtk_arm.hpp"
#include "core/lock_free.hpp"

namespace veridyn_ros {

/// Positions that came from an arm's motors, and torques on their way to them.
struct MotorState {
  double q[kMostJoints] = {}, dq[kMostJoints] = {};
  double stamp = 0.0;  ///< [s] of the steady clock, when it came
  bool seen = false;
};
struct MotorTorque {
  double tau[kMostJoints] = {};
  double stamp = 0.0;
};

/// [s] of a clock that never jumps.
double steady_now() noexcept;

/// Waits until the next cycle; never tries to catch up with cycles that were missed.
class Cycle {
 public:
  explicit Cycle(double period);
  /// @returns [s] since the last call, as it was.
  double wait() noexcept;
  double latest() const { return latest_; }  ///< [s] by which the last cycle began too late

 private:
  double period_, next_, last_, latest_ = 0.0;
};

/// What a loop says of itself.
struct LoopFigures {
  double cycles = 0.0, mean_period = 0.0, worst_late = 0.0, worst_compute = 0.0, overruns = 0.0;
};

}  // namespace veridyn_ros
