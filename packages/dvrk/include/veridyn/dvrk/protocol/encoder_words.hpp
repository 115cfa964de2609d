#pragma once

#include <cstdint>

namespace veridyn::dvrk {

/// Ticks per second of the counters in firmware 7 and later.
constexpr double kEncoderClock = 49.152e6;

/// The counter value for position zero.
constexpr std::int32_t kEncoderZero = 0x800000;

/// Words of the FPGA for one encoder (firmware 7 and later), in the order of the block read.
/// Defaults are those at power-up.
struct EncoderWords {
  std::uint32_t position = 0x800000;
  std::uint32_t period = 0xCBFFFFFF;    ///< time of the last four edges
  std::uint32_t quarter1 = 0x43FFFFFF;  ///< time of the last quarter
  std::uint32_t quarter5 = 0x43FFFFFF;  ///< time of the quarter five edges ago
  std::uint32_t running = 0x83FFFFFF;   ///< time since the last edge
};

/// Motion of one encoder in counts, counts/s, counts/s^2.
struct EncoderMotion {
  double velocity = 0.0;      ///< mean over the last four edges
  double acceleration = 0.0;  ///< from the velocities of two periods that are one edge apart
  double predicted = 0.0;     ///< velocity extrapolated to the present
};

/// Value of 1/quarter (in clock ticks) above which the dVRK software computes no acceleration: for
/// quarters shorter than 2000 ticks, 41 us.
constexpr double kAccelerationThreshold = 0.0005;

/// Position in counts, -2^23 .. 2^23 - 1.
std::int32_t encoder_counts(std::uint32_t position) noexcept;

/// True if the counter has overflowed since it was loaded: positions are invalid.
bool encoder_overflow(std::uint32_t position) noexcept;

/// True if the period word reports an impossible transition.
bool encoder_error(std::uint32_t period) noexcept;

/// The word that loads the counter with `counts`, limited to 24 bits.
std::uint32_t preload_word(std::int64_t counts) noexcept;

/// Velocity, acceleration, and the velocity extrapolated to the present.
///
///   v = +-4 / (P T),  a = +-8 (q5 - q1) / (P Pp T^2 (q1 + q5)),  Pp = P - q1 + q5
///   predicted = v + a (P T/2 + r T), of v's sign and no faster than 1/(r T)
///
/// with T the clock's tick and P, q1, q5, r the 26-bit times. All zero at rest (overflow) and after
/// a change of direction.
EncoderMotion encoder_motion(const EncoderWords& words,
                             double threshold = kAccelerationThreshold) noexcept;

}  // namespace veridyn::dvrk
