#pragma once

#include <algorithm>
#include <ctime>
#include <optional>

#include "dvrk/protocol/datagram_link.hpp"
#include "dvrk/run/loop_timing.hpp"

namespace veridyn::dvrk {

/// Begins cycles at a fixed rate, and counts late cycles and gaps between writes. One cycle is begin(),
/// reading, read(), computing and writing, end().
class CycleClock {
 public:
  /// @param rate  [Hz] of the cycles.
  CycleClock(DatagramLink& link, double rate) : link_(link), period_(1.0 / rate) {
    restart_count();
  }

  /// Waits for the next cycle. @returns its time [s].
  double begin() noexcept {
    double now = link_.now();
    gap_ = WriteGap();
    late_ = false;
    if (!next_) next_ = window_began_ = now;  // the first cycle
    const double entered = now;
    if (now < *next_) {
      link_.wait(*next_ - now);
      now = link_.now();
      gap_.slept = std::max(0.0, *next_ - entered);
      gap_.woken_late = std::max(0.0, now - *next_);
    }
    if (now - *next_ > period_) {
      late_ = true;
      next_ = now;
    }
    *next_ += period_;
    began_ = now;
    cpu_ = processor_seconds();
    return now;
  }

  /// Call after reading the boards. @param lay  [s] between the arrival of the replies and their
  /// reading.
  void read(double lay) noexcept {
    const double took = link_.now() - began_;
    const double cpu = processor_seconds();
    gap_.own = cpu - cpu_;
    gap_.interrupted = std::min(lay, took);
    gap_.replies = std::max(0.0, took - gap_.own - gap_.interrupted);
    read_at_ = began_ + took;
    cpu_ = cpu;
  }

  /// Call after writing: updates the timing with this cycle and the gap since the previous write.
  void end() noexcept {
    const double now = link_.now();
    const double took = now - began_;
    const double worked = processor_seconds() - cpu_;
    gap_.own += worked;
    gap_.interrupted += std::max(0.0, now - read_at_ - worked);
    if (written_) {
      gap_.seconds = now - *written_;
      gap_.at = now - first_;
      if (gap_.seconds > timing_.longest_gap.seconds) timing_.longest_gap = gap_;
    }
    // The cause of a late cycle is in the preceding gap, or the thread was woken late.
    if (late_) count_late(gap_.woken_late > period_ ? gap_ : before_);
    before_ = gap_;
    written_ = now;
    if (timing_.cycles == 0) first_ = began_;
    ++timing_.cycles;
    timing_.seconds = now - first_;
    timing_.longest = std::max(timing_.longest, took);
    timing_.mean += (took - timing_.mean) / static_cast<double>(timing_.cycles);
    watch_rate(now);
  }

  /// True if less than half of the cycles were on time for half a second.
  bool persistently_late() const { return persistently_late_; }
  /// Number of cycles in the last such window, and of those that were due.
  long cycles_in_window() const { return window_had_; }
  long cycles_due() const { return window_due_; }

  /// Clears the counts of late cycles, at the beginning of the motion.
  void restart_count() noexcept {
    const double rate = 1.0 / period_;
    timing_ = LoopTiming();
    timing_.rate = rate;
    written_.reset();
  }
  const LoopTiming& timing() const { return timing_; }

 private:
  // [s] processor time of this thread.
  static double processor_seconds() noexcept {
    timespec at{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &at);
    return static_cast<double>(at.tv_sec) + 1e-9 * static_cast<double>(at.tv_nsec);
  }

  void count_late(const WriteGap& gap) noexcept {
    ++timing_.late;
    const LateReason reason = reason_of(gap);
    timing_.late_own += reason == LateReason::kOwn ? 1 : 0;
    timing_.late_replies += reason == LateReason::kReplies ? 1 : 0;
  }

  // Counts the cycle at `now` [s]; at the end of a window sets persistently_late_.
  void watch_rate(double now) noexcept {
    ++window_cycles_;
    const double window = std::max(kWindow, kLeastPeriods * period_);
    if (now - window_began_ < window) return;
    window_due_ = static_cast<long>((now - window_began_) / period_);
    window_had_ = window_cycles_;
    persistently_late_ =
        static_cast<double>(window_had_) < kLeastShare * static_cast<double>(window_due_);
    window_cycles_ = 0;
    window_began_ = now;
  }

  static constexpr double kWindow = 0.5;  // [s] interval over which the rate is checked
  static constexpr double kLeastPeriods = 20.0;
  static constexpr double kLeastShare = 0.5;

  DatagramLink& link_;
  double period_;
  std::optional<double> next_, written_;
  double began_ = 0.0, read_at_ = 0.0, first_ = 0.0, cpu_ = 0.0;
  bool late_ = false;
  WriteGap gap_, before_;
  LoopTiming timing_;
  double window_began_ = 0.0;
  long window_cycles_ = 0, window_had_ = 0, window_due_ = 0;
  bool persistently_late_ = false;
};

}  // namespace veridyn::dvrk
