#pragma once

#include "veridyn/dvrk/config/io_config.hpp"

namespace veridyn::dvrk {

/// The current of one brake over time: a pulse that opens it, then a smaller current that keeps it open; zero
/// (or the configured value) while it holds.
class BrakeDriver {
 public:
  enum class Wish { kEngaged, kReleased };

  explicit BrakeDriver(const BrakeConfig& brake) : brake_(brake) {}

  /// @param now [s] of a clock that never decreases. @returns [A].
  double current(Wish wish, double now) noexcept;

  /// True after the pulse: the joint may move.
  bool released() const { return phase_ == Phase::kReleased; }
  const BrakeConfig& config() const { return brake_; }

 private:
  enum class Phase { kEngaged, kPush, kReleased };

  BrakeConfig brake_;
  Phase phase_ = Phase::kEngaged;
  double pushed_at_ = 0.0;
};

}  // namespace veridyn::dvrk
