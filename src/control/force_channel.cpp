#include <algorithm>
#include <cmath>
#include <utility>

#include "veridyn/control/load_cell.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {

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
              options.cutoff >= 0.0 && options.latency >= 0.0,
          "force channel: found a bound below zero.");
}

double ForceChannel::delay() const {
  const double filter = options_.cutoff > 0.0 ? 1.0 / (2.0 * M_PI * options_.cutoff) : 0.0;
  return options_.latency + filter;
}

ForceReading ForceChannel::update(double now) noexcept {
  const int fresh = source_->poll();
  if (number_ < 0 && fresh == 0) return {};
  if (fresh > 0) {
    const double raw = source_->raw();
    force_ = options_.calibration.scale * (raw - options_.calibration.offset);
    const bool alike = number_ >= 0 && raw == last_raw_;
    alike_ = alike ? alike_ + fresh : 0;
    if (!alike) changed_ = now;
    if (number_ < 0) {
      filtered_ = force_;
    } else if (options_.cutoff > 0.0) {
      const double since = std::max(0.0, now - heard_);
      filtered_ += (1.0 - std::exp(-2.0 * M_PI * options_.cutoff * since)) * (force_ - filtered_);
    } else {
      filtered_ = force_;
    }
    last_raw_ = raw;
    heard_ = now;
    number_ += fresh;
  }
  state_ = ForceState::kGood;
  if (!(std::abs(force_) <= options_.range)) state_ = ForceState::kRange;
  if (options_.stuck_after > 0.0 && alike_ >= options_.stuck_readings &&
      now - changed_ > options_.stuck_after)
    state_ = ForceState::kStuck;
  if (now - heard_ > options_.largest_silence || !source_->connected()) state_ = ForceState::kDead;
  return {filtered_, now - heard_ + options_.latency, number_, force_};
}

}  // namespace veridyn
