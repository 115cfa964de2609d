#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "core/crtk_arm.hpp"
#include "core/lock_free.hpp"

namespace veridyn_ros {

/// Positions from an arm's motors, and torques to be sent to them.
struct MotorState {
  double q[kMostJoints] = {}, dq[kMostJoints] = {}, tau[kMostJoints] = {};
  bool powered = true;  ///< true if torques take effect
  double stamp = 0.0;  ///< [s] time of the arrival, by the steady clock
  double said = 0.0;   ///< [s] time in the message, by ROS' clock
  bool seen = false;
};
struct MotorTorque {
  double tau[kMostJoints] = {};
  double stamp = 0.0;
  double said = 0.0;  ///< [s] of ROS' clock: stamp of the positions that the torques are for; 0: unknown
};

/// [s] Present time of a clock that never jumps.
double steady_now() noexcept;

/// Waits until the next cycle; cycles that were missed are skipped.
class Cycle {
 public:
  explicit Cycle(double period);  ///< [s]
  /// @returns [s] since the last call.
  double wait() noexcept;
  double latest() const { return latest_; }  ///< [s] delay of the last cycle's start

 private:
  double period_, next_, last_, latest_ = 0.0;
};

/// Histogram of times [s] in steps of 5 %; add_time() neither allocates nor waits.
class TimeHistogram {
 public:
  void add_time(double seconds) noexcept;
  /// [s] quantile of the times, to 5 %; 0 if there are none.
  double quantile(double share) const noexcept;
  double worst() const noexcept { return worst_; }  ///< [s] largest time

 private:
  std::array<std::uint32_t, 332> counts_{};  // one count per step of 5 % from 1 us to 10 s
  std::uint64_t all_ = 0;
  double worst_ = 0.0;
};

/// Timing of a loop.
struct LoopFigures {
  double cycles = 0.0, mean_period = 0.0, overruns = 0.0;
  TimeHistogram late;     ///< [s] delays of the starts of cycles
  TimeHistogram compute;  ///< [s] computation times of cycles

  /// "600000 cycles of 1.000 ms, ...; processor 31 % of a core", of a run of `seconds`.
  std::string timing_text(double seconds) const;
};

/// "median 0.10, 99.9 % 0.35, worst 2.10 ms"
std::string histogram_text(const TimeHistogram& spread);

}  // namespace veridyn_ros
