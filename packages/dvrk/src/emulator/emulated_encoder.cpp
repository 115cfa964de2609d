#include "emulator/emulated_encoder.hpp"

#include <algorithm>
#include <cmath>

namespace veridyn::dvrk {
namespace {

constexpr std::uint32_t kMost = 0x3FFFFFF;  // largest value of a 26-bit counter
constexpr std::uint32_t kOverflowBit = 1U << 31;
constexpr std::uint32_t kUpBit = 1U << 30;
constexpr std::int64_t kHalf = 0x800000;
constexpr double kRev6Ratio = 16.0;  // 49.152 MHz to 3.072 MHz

// Rounded to whole ticks, at most kMost.
std::uint32_t saturated(double ticks) {
  return ticks >= static_cast<double>(kMost) ? kMost : static_cast<std::uint32_t>(ticks + 0.5);
}

// Kind of the edge that leads to this count when counting up; A leads by a quarter on counts that are
// multiples of four.
std::uint32_t kind_up(std::int64_t count) {
  static constexpr std::uint32_t kKinds[] = {8, 4, 2, 1};
  return kKinds[((count % 4) + 4) % 4];
}

// Kind of the same edge when counting down.
std::uint32_t reversed(std::uint32_t kind) {
  return kind >= 4 ? kind >> 2 : kind << 2;
}

}  // namespace

void EmulatedEncoder::power_up(double counts, Ticks now) noexcept {
  *this = EmulatedEncoder();
  counts_ = counts;
  count_ = static_cast<std::int64_t>(std::floor(counts));
  offset_ = kHalf - count_;
  moved_at_ = now;
  last_edge_ = static_cast<double>(now) - 2.0 * kMost;
}

void EmulatedEncoder::edge(std::int64_t crossed, bool up, double at) noexcept {
  for (int k = 4; k > 0; --k) recent_[k] = recent_[k - 1];
  const std::uint32_t kind = kind_up(crossed);
  const double seen = std::floor(at);  // time in whole ticks of the counter
  recent_[0] = {saturated(seen - last_edge_), up, up ? kind : reversed(kind)};
  last_edge_ = seen;
  ++edges_;
}

void EmulatedEncoder::move(double counts, Ticks now) noexcept {
  if (stuck) return;
  const auto target = static_cast<std::int64_t>(std::floor(counts));
  const auto start = static_cast<double>(moved_at_);
  const double rate =
      counts == counts_ ? 0.0 : static_cast<double>(now - moved_at_) / (counts - counts_);
  const auto time_of = [&](std::int64_t crossing) {
    return start + (static_cast<double>(crossing) - counts_) * rate;
  };
  // Only the last edges are stored.
  if (target > count_) {
    std::int64_t k = count_ + 1;
    if (target - k > 6) {
      edges_ += target - 6 - k;
      k = target - 6;
      last_edge_ = std::floor(time_of(k - 1));
    }
    for (; k <= target; ++k) edge(k, true, time_of(k));
  } else if (target < count_) {
    std::int64_t k = count_;
    if (k - target > 7) {
      edges_ += k - target - 7;
      k = target + 7;
      last_edge_ = std::floor(time_of(k + 1));
    }
    for (; k > target; --k) edge(k, false, time_of(k));
  }
  counts_ = counts;
  count_ = target;
  moved_at_ = now;
  const std::int64_t counter = count_ + offset_;
  if (counter < 0 || counter >= 2 * kHalf) overflow_latched = true;
}

void EmulatedEncoder::preload(std::uint32_t word) noexcept {
  preload_ = word & 0xFFFFFF;
  offset_ = static_cast<std::int64_t>(preload_) - count_;
}

// Section 11.2. Before the first edge the words have their power-up values.
std::uint32_t EmulatedEncoder::period_word(bool stale) const noexcept {
  const std::uint32_t partial = edges_ < 5 ? 1U << 27 : 0U;
  const std::uint32_t error = broken_lines ? 1U << 28 : 0U;
  if (edges_ == 0) return 0xCBFFFFFF | error;
  double sum = 0.0;
  bool changed = false;
  for (int k = 0; k < 4; ++k) {
    sum += recent_[k].quarter;
    if (k > 0 && k < edges_) changed = changed || recent_[k].up != recent_[0].up;
  }
  const bool over = stale || edges_ < 5 || sum >= static_cast<double>(kMost);
  return (over ? kOverflowBit : 0U) | (recent_[0].up ? kUpBit : 0U) | (changed ? 1U << 29 : 0U) |
         error | partial | (over ? kMost : saturated(sum));
}

EncoderWords EmulatedEncoder::words(int firmware, Ticks now) const noexcept {
  EncoderWords w;
  const std::uint32_t overflow = overflow_latched ? 1U << 24 : 0U;
  const std::uint32_t lines = (line_a() ? 1U << 28 : 0U) | (line_b() ? 1U << 29 : 0U);
  w.position = (static_cast<std::uint32_t>(count_ + offset_) & 0xFFFFFF) | overflow |
               (firmware >= 8 ? lines : 0U);
  const double since = static_cast<double>(now) - last_edge_;
  const bool stale = since >= static_cast<double>(kMost);
  w.period = period_word(stale);
  if (edges_ == 0) return w;
  const auto quarter = [&](const Edge& e) {
    const bool over = e.quarter >= kMost;
    return (over ? kOverflowBit : 0U) | (e.up ? kUpBit : 0U) | (e.kind << 26) | e.quarter;
  };
  w.quarter1 = quarter(recent_[0]);
  w.quarter5 = edges_ >= 5 ? quarter(recent_[4]) : 0x43FFFFFF;
  w.running =
      (stale ? kOverflowBit : 0U) | (recent_[0].up ? kUpBit : 0U) | saturated(std::max(0.0, since));
  if (firmware >= 7) return w;
  // Rev 6: a slower clock, and the quarters packed into two words.
  const double period = (w.period & kMost) / kRev6Ratio;
  const auto q1 = static_cast<std::uint32_t>(std::min(1048575.0, recent_[0].quarter / kRev6Ratio));
  const auto q5 = static_cast<std::uint32_t>(std::min(1048575.0, recent_[4].quarter / kRev6Ratio));
  w.period = (w.period & (kOverflowBit | kUpBit)) | ((q1 & 0xFF) << 22) |
             static_cast<std::uint32_t>(std::min(4194303.0, period));
  w.quarter1 = ((q1 >> 8) << 20) | q5;
  return w;
}

}  // namespace veridyn::dvrk
