#pragma once

#include <cstdint>

namespace veridyn::dvrk {

/// What a board says of one encoder: section 11. Rev 6 has `period` and `quarter1` alone, the
/// second being its word of accelerations.
struct EncoderWords {
  std::uint32_t position = 0x800000;
  std::uint32_t period = 0;
  std::uint32_t quarter1 = 0;
  std::uint32_t quarter5 = 0;
  std::uint32_t running = 0;

  /// Section 11.1: counts from mid-range.
  std::int32_t counts() const { return static_cast<std::int32_t>(position & 0xFFFFFF) - 0x800000; }
  bool overflow() const { return ((position >> 24) & 1U) != 0; }
  /// Section 11.2, Rev 7 on: an illegal transition of the lines.
  bool error() const { return ((period >> 28) & 1U) != 0; }
};

/// The word to write to a channel's preload for these counts.
constexpr std::uint32_t preload_word(std::int32_t counts) {
  return static_cast<std::uint32_t>(counts + 0x800000) & 0xFFFFFFU;
}

/// [counts/s], [counts/s^2]
struct EncoderMotion {
  double velocity = 0.0;      ///< mean over the last four edges
  double acceleration = 0.0;  ///< between the last two cycles of edges
  double predicted = 0.0;     ///< velocity now, bounded by what the wait for the next edge allows
};

/// The host's formulas of section 11.2.
/// @param threshold  no acceleration above 1 / threshold ticks of a quarter (the laboratory's
///                   software: 0.0005).
EncoderMotion encoder_motion(const EncoderWords& words, int firmware,
                             double threshold = 0.0005) noexcept;

}  // namespace veridyn::dvrk
