#include "veridyn/dvrk/encoder.hpp"

#include <algorithm>
#include <cmath>

namespace veridyn::dvrk {
namespace {

constexpr std::uint32_t kField = 0x3FFFFFF;  // 25:0, section 11.2

// The fields of the words, by firmware: times in ticks.
struct Times {
  double tick = 0.0;  // [s]
  double period = 0.0, quarter1 = 0.0, quarter5 = 0.0, running = 0.0;
  double previous_period = 0.0;
  bool no_velocity = false, no_acceleration = false;
  bool has_running = false;
  double sign = 1.0;
};

bool bit(std::uint32_t word, int k) { return ((word >> k) & 1U) != 0; }

Times times_rev7(const EncoderWords& w) noexcept {
  Times t;
  t.tick = 1.0 / 49.152e6;
  t.period = w.period & kField;
  t.quarter1 = w.quarter1 & kField;
  t.quarter5 = w.quarter5 & kField;
  t.running = w.running & kField;
  t.has_running = true;
  t.previous_period = bit(w.quarter5, 31) ? kField : t.period - t.quarter1 + t.quarter5;
  t.sign = bit(w.period, 30) ? 1.0 : -1.0;
  t.no_velocity = bit(w.period, 31) || bit(w.period, 29);
  t.no_acceleration = bit(w.period, 31) || ((w.quarter1 ^ w.quarter5) & 0x7C000000U) != 0;
  return t;
}

// Section 11.2, end: the quarter is spread over both words and saturates at 20 bits.
Times times_rev6(const EncoderWords& w) noexcept {
  Times t;
  t.tick = 1.0 / 3.072e6;
  t.period = w.period & 0x3FFFFF;
  t.quarter1 = ((w.quarter1 >> 20) << 8) | ((w.period >> 22) & 0xFF);
  t.quarter5 = w.quarter1 & 0xFFFFF;
  t.previous_period = t.period - t.quarter1 + t.quarter5;
  t.sign = bit(w.period, 30) ? 1.0 : -1.0;
  t.no_velocity = bit(w.period, 31);
  t.no_acceleration = t.no_velocity || t.quarter1 >= 0xFFFFF || t.quarter5 >= 0xFFFFF;
  return t;
}

double acceleration(const Times& t, double threshold) noexcept {
  if (t.no_acceleration || t.period <= 0.0 || t.previous_period <= 0.0) return 0.0;
  if (t.quarter1 <= 0.0 || t.quarter5 <= 0.0 || 1.0 / t.quarter1 > threshold) return 0.0;
  return t.sign * 8.0 * (t.quarter5 - t.quarter1) /
         (t.period * t.previous_period * t.tick * t.tick * (t.quarter1 + t.quarter5));
}

double predicted(const Times& t, double v, double a) noexcept {
  if (v == 0.0) return 0.0;
  const double now = v + a * t.tick * (0.5 * t.period + t.running);
  if (now * v < 0.0) return 0.0;
  if (!t.has_running || t.running <= 0.0) return now;
  const double most = 1.0 / (t.running * t.tick);
  return std::clamp(now, -most, most);
}

}  // namespace

EncoderMotion encoder_motion(const EncoderWords& words, int firmware, double threshold) noexcept {
  const Times t = firmware >= 7 ? times_rev7(words) : times_rev6(words);
  EncoderMotion motion;
  if (!t.no_velocity) motion.velocity = t.sign * 4.0 / (std::max(1.0, t.period) * t.tick);
  motion.acceleration = acceleration(t, threshold);
  motion.predicted = predicted(t, motion.velocity, motion.acceleration);
  return motion;
}

}  // namespace veridyn::dvrk
