#include <algorithm>
#include <cmath>
#include <utility>

#include "veridyn/control/load_cell.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr int kMostReadings = 256;  // largest number of readings per update, to bound its time

}  // namespace

const char* describe(ForceState state) {
  switch (state) {
    case ForceState::kWaiting:
      return "waits for its first reading";
    case ForceState::kGood:
      return "is good";
    case ForceState::kDead:
      return "is dead: nothing comes any more";
    case ForceState::kStuck:
      return "is stuck: it repeats one reading";
    case ForceState::kRange:
      return "is beyond its range";
    case ForceState::kNoisy:
      return "comes over a damaged line: too much of what arrives cannot be used";
  }
  return "";
}

ForceChannel::ForceChannel(std::unique_ptr<ForceSource> source, const ForceChannelOptions& options)
    : source_(std::move(source)), options_(options) {
  require(source_ != nullptr, "force channel: found no source.");
  require(options.calibration.scale != 0.0 && std::isfinite(options.calibration.scale) &&
              std::isfinite(options.calibration.offset),
          "force channel: found a scale or an offset that cannot be.");
  require(options.largest_silence > 0.0 && options.stuck_after >= 0.0 && options.range > 0.0 &&
              options.cutoff >= 0.0 && options.latency >= 0.0 && options.largest_jump > 0.0 &&
              options.noisy_share > 0.0 && options.noisy_window > 0 &&
              std::isfinite(options.cutoff) && std::isfinite(options.latency),
          "force channel: found a bound below zero, or a cutoff or latency that is not finite.");
}

double ForceChannel::delay() const {
  const double filter = options_.cutoff > 0.0 ? 1.0 / (2.0 * M_PI * options_.cutoff) : 0.0;
  return options_.latency + filter;
}

// False for a force beyond the range, or a step that a second reading has not yet confirmed; counts both.
bool ForceChannel::is_accepted(double force) noexcept {
  beyond_ = !(std::abs(force) <= options_.range) || !std::isfinite(force);
  if (beyond_) {
    ++beyond_range_;
    return false;
  }
  const bool agrees = !number_ || std::abs(force - force_) <= options_.largest_jump ||
                      (waits_ && std::abs(force - waiting_) <= options_.largest_jump);
  waits_ = !agrees;
  waiting_ = force;
  if (!agrees) ++jumps_;
  return agrees;
}

// Counts usable and unusable data in consecutive windows, and sets noisy_.
void ForceChannel::count_readings(long good, long bad) noexcept {
  good_ += good;
  bad_ += bad;
  const auto all = static_cast<double>(good_ + bad_);
  if (static_cast<double>(bad_) > options_.noisy_share * options_.noisy_window) noisy_ = true;
  if (all < options_.noisy_window) return;
  noisy_ = static_cast<double>(bad_) > options_.noisy_share * all;
  good_ = bad_ = 0;
}

// Processes the latest of `fresh` readings, which arrived at time `at` [s].
void ForceChannel::accept_readings(int fresh, double at) noexcept {
  const double raw = source_->raw();
  const double force = options_.calibration.scale * (raw - options_.calibration.offset);
  const bool believed = is_accepted(force);
  count_readings(believed ? fresh : 0, believed ? 0 : fresh);
  if (!believed) return;
  force_ = force;
  const bool alike = number_ && raw == last_raw_;
  alike_ = alike ? std::min(alike_ + fresh, options_.stuck_readings) : 0;
  if (!alike) changed_ = at;
  if (!number_ || options_.cutoff <= 0.0) {
    filtered_ = force_;
  } else {
    const double since = std::max(0.0, at - heard_);
    filtered_ += (1.0 - std::exp(-2.0 * M_PI * options_.cutoff * since)) * (force_ - filtered_);
  }
  last_raw_ = raw;
  heard_ = !number_ ? at : std::max(heard_, at);
  number_ = number_.value_or(-1) + fresh;
}

ForceReading ForceChannel::update(double now) noexcept {
  if (std::isnan(begun_)) begun_ = now;
  for (int k = 0; k < kMostReadings; ++k) {
    const int fresh = source_->poll();
    if (fresh <= 0) break;
    accept_readings(fresh, now - source_->queue_delay());
  }
  const long refused = source_->rejected_readings();
  count_readings(0, refused - refused_);
  refused_ = refused;
  if (!number_) {
    state_ = beyond_ ? ForceState::kRange : ForceState::kWaiting;
    return {0.0, now - begun_ + options_.latency, {}};
  }
  state_ = ForceState::kGood;
  if (noisy_) state_ = ForceState::kNoisy;
  if (beyond_) state_ = ForceState::kRange;
  if (options_.stuck_after > 0.0 && alike_ >= options_.stuck_readings &&
      now - changed_ > options_.stuck_after)
    state_ = ForceState::kStuck;
  if (now - heard_ > options_.largest_silence || !source_->connected()) state_ = ForceState::kDead;
  return {filtered_, now - heard_ + options_.latency, number_, force_};
}

}  // namespace veridyn
