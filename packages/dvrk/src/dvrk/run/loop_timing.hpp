#pragma once

#include <string>

namespace veridyn::dvrk {

/// The time between two writes to the boards, and its parts. All [s].
struct WriteGap {
  double at = 0.0;           ///< time of its end since the loop began
  double seconds = 0.0;      ///< time between the two writes
  double slept = 0.0;        ///< planned sleep
  double woken_late = 0.0;   ///< delay of the wake-up by the system
  double replies = 0.0;      ///< waiting for the boards and the network
  double own = 0.0;          ///< processor time of this program
  double interrupted = 0.0;  ///< ready to run while the system ran another program
};

/// Cause of a late cycle or a gap: the largest part that was not planned.
enum class LateReason {
  kSystem,   ///< the program was woken late, or interrupted
  kReplies,  ///< late replies of boards or network
  kOwn       ///< this program's own work
};
LateReason reason_of(const WriteGap& gap);
/// "the system woke this program 12.10 ms late"; "as planned" if less than a tenth of the gap was not.
std::string describe_reason(const WriteGap& gap);

/// Timing of a loop.
struct LoopTiming {
  long cycles = 0;
  long late = 0;          ///< cycles that began more than one period late
  long late_own = 0;      ///< late cycles due to this program's own computation
  /// Of these, late because of replies from boards or network; the others are due to the system.
  long late_replies = 0;
  double longest = 0.0;   ///< [s] longest duration of a cycle
  double mean = 0.0;      ///< [s] mean duration of a cycle
  double seconds = 0.0;   ///< [s] from the start of the first cycle to the end of the last
  double rate = 0.0;      ///< [Hz] requested rate
  WriteGap longest_gap;

  /// Measured number of cycles per second.
  double measured_rate() const { return seconds > 0.0 ? static_cast<double>(cycles) / seconds : rate; }
};

}  // namespace veridyn::dvrk
