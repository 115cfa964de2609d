#pragma once

#include <cstdint>

#include "veridyn/emulator/board_load.hpp"
#include "veridyn/dvrk/protocol/encoder_words.hpp"

namespace veridyn::dvrk {

/// A quadrature encoder with its counters: specification 11. Between two calls of move() it turns at a constant
/// speed; every edge has a time.
class EmulatedEncoder {
 public:
  /// Sets the shaft position at power-up.
  void power_up(double counts, Ticks now) noexcept;

  /// Moves the shaft to `counts` at a constant speed since the last call.
  void move(double counts, Ticks now) noexcept;

  /// Adds `counts` to the counter, as after missed edges.
  void slip(std::int64_t counts) noexcept { offset_ += counts; }

  /// Loads the counter with a 24-bit word.
  void preload(std::uint32_t word) noexcept;
  std::uint32_t last_preload() const { return preload_; }

  /// Registers of the counter as this firmware gives them, at the time `now`.
  EncoderWords words(int firmware, Ticks now) const noexcept;

  /// Levels of the lines A and B.
  bool line_a() const { return phase() == 0 || phase() == 1; }
  bool line_b() const { return phase() == 1 || phase() == 2; }

  // Faults of the hardware, active while they are set.
  bool broken_lines = false;      ///< illegal transitions
  bool stuck = false;             ///< the counter does not change
  bool overflow_latched = false;  ///< section 11.1: sticky; not cleared by a preload

 private:
  struct Edge {
    std::uint32_t quarter = 0;  ///< ticks since the previous edge
    bool up = false;
    std::uint32_t kind = 0;  ///< A-up 8, B-up 4, A-down 2, B-down 1
  };

  std::int64_t phase() const { return ((count_ % 4) + 4) % 4; }  ///< quarter of the line period, 0 to 3
  void edge(std::int64_t crossed, bool up, double at) noexcept;  ///< stores an edge at the time `at` [ticks]
  std::uint32_t period_word(bool stale) const noexcept;

  double counts_ = 0.0;      ///< Counts of the shaft
  std::int64_t count_ = 0;   ///< integer part of counts_
  std::int64_t offset_ = 0;  ///< counter minus count_
  std::uint32_t preload_ = 0x800000;
  Ticks moved_at_ = 0;
  double last_edge_ = 0.0;  ///< [ticks]
  std::int64_t edges_ = 0;
  Edge recent_[5];  ///< newest first
};

}  // namespace veridyn::dvrk
