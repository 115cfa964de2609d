#include "dvrk/protocol/encoder_words.hpp"

#include <algorithm>
#include <cmath>

namespace veridyn::dvrk {
namespace {

constexpr std::uint32_t kOverflow = 1U << 31;
constexpr std::uint32_t kPositive = 1U << 30;
constexpr std::uint32_t kDirectionChanged = 1U << 29;
constexpr std::uint32_t kIllegalTransition = 1U << 28;
constexpr std::uint32_t kEdgeKind = 0xFU << 26;
constexpr std::uint32_t kTime = 0x3FFFFFF;

double ticks(std::uint32_t word) {
  return word & kTime;
}

double direction(std::uint32_t word) {
  return (word & kPositive) != 0 ? 1.0 : -1.0;
}

// Acceleration in counts per tick^2; 0 if the two periods cannot be compared.
double acceleration_per_tick2(const EncoderWords& w, double threshold) {
  const double P = ticks(w.period);
  const double q1 = ticks(w.quarter1);
  const double q5 = ticks(w.quarter5);
  const double previous = (w.quarter5 & kOverflow) != 0 ? static_cast<double>(kTime) : P - q1 + q5;
  const bool same_kind = ((w.quarter1 ^ w.quarter5) & (kEdgeKind | kPositive)) == 0;
  if (!same_kind || P <= 0.0 || q1 <= 0.0 || q5 <= 0.0 || previous <= 0.0) return 0.0;
  if (1.0 / q1 > threshold) return 0.0;
  return direction(w.period) * 8.0 * (q5 - q1) / (P * previous * (q1 + q5));
}

// Predicted velocity in counts per tick.
double predicted_per_tick(double velocity, double acceleration, double P, double running) {
  const double now = velocity + acceleration * (0.5 * P + running);
  if (now * velocity <= 0.0) return 0.0;
  return running > 0.0 ? std::copysign(std::min(std::abs(now), 1.0 / running), now) : now;
}

}  // namespace

std::int32_t encoder_counts(std::uint32_t position) noexcept {
  return static_cast<std::int32_t>(position & 0xFFFFFF) - kEncoderZero;
}

bool encoder_overflow(std::uint32_t position) noexcept {
  return (position & (1U << 24)) != 0;
}

bool encoder_error(std::uint32_t period) noexcept {
  return (period & kIllegalTransition) != 0;
}

std::uint32_t preload_word(std::int64_t counts) noexcept {
  const std::int64_t zero = kEncoderZero;
  return static_cast<std::uint32_t>(std::clamp(counts, -zero, zero - 1) + zero);
}

EncoderMotion encoder_motion(const EncoderWords& words, double threshold) noexcept {
  if ((words.period & (kOverflow | kDirectionChanged)) != 0) return {};
  const double P = std::max(ticks(words.period), 1.0);
  const double velocity = direction(words.period) * 4.0 / P;
  const double acceleration = acceleration_per_tick2(words, threshold);
  const double predicted = predicted_per_tick(velocity, acceleration, P, ticks(words.running));
  return {velocity * kEncoderClock, acceleration * kEncoderClock * kEncoderClock,
          predicted * kEncoderClock};
}

}  // namespace veridyn::dvrk
