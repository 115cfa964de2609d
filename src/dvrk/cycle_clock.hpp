#pragma once

#include <algorithm>

#include "veridyn/dvrk/arm_run.hpp"
#include "veridyn/dvrk/datagram_link.hpp"

namespace veridyn::dvrk {

/// Begins cycles at a fixed rate and keeps count of those that came late.
class CycleClock {
 public:
  CycleClock(DatagramLink& link, double rate)
      : link_(link), period_(1.0 / rate), next_(link.now()) {}

  /// Waits for the next cycle. @returns its time [s].
  double begin() noexcept {
    double now = link_.now();
    if (now < next_) {
      link_.wait(next_ - now);
      now = link_.now();
    } else if (now - next_ > period_) {
      ++timing_.late;
      next_ = now;
    }
    next_ += period_;
    began_ = now;
    return now;
  }

  void end() noexcept {
    const double took = link_.now() - began_;
    ++timing_.cycles;
    timing_.longest = std::max(timing_.longest, took);
    timing_.mean += (took - timing_.mean) / static_cast<double>(timing_.cycles);
  }

  /// Forgets what was slow so far: the motion begins.
  void restart_count() noexcept { timing_ = LoopTiming(); }
  const LoopTiming& timing() const { return timing_; }

 private:
  DatagramLink& link_;
  double period_;
  double next_;
  double began_ = 0.0;
  LoopTiming timing_;
};

}  // namespace veridyn::dvrk
