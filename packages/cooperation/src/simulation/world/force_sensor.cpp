#include "veridyn/simulation/force_sensor.hpp"

#include <algorithm>
#include <cmath>

#include "veridyn/math/random_numbers.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr double kSameTime = 1e-9;  // [s] tolerance of times that count as equal

}  // namespace

struct ForceSensor::State {
  State(const ForceSensorOptions& given, double longest_period)
      : options(given), random(given.seed) {
    const double on_the_way = (given.delay + longest_period) * given.rate;
    ring.resize(static_cast<size_t>(std::ceil(on_the_way)) + 4);
  }

  // Reading of a true force [N], with noise and in whole steps.
  double measured(double force) {
    const double noisy = force + options.noise * random.normal();
    return options.step > 0.0 ? std::round(noisy / options.step) * options.step : noisy;
  }

  ForceSensorOptions options;
  RandomNumbers random;
  std::vector<ForceSample> ring;  // samples not yet delivered, by number
  long taken = 0, arrived = 0;
  ForceSample latest;
};

ForceSensor::ForceSensor(const ForceSensorOptions& options, double longest_period) {
  require(std::isfinite(options.rate) && options.rate > 0.0, "force sensor: found a rate of ",
          options.rate, " Hz, expected a number above zero.");
  require(std::isfinite(options.delay) && options.delay >= 0.0 && options.noise >= 0.0 &&
              options.step >= 0.0 && longest_period > 0.0,
          "force sensor: found a delay, a noise or a step below zero.");
  const double under_way = (options.delay + longest_period) * options.rate;
  require(under_way < kMostUnderWay, "force sensor: found ", options.rate, " Hz with a delay of ", options.delay,
          " s, expected fewer than ", kMostUnderWay, " samples on their way.");
  state_ = std::make_unique<State>(options, longest_period);
}

ForceSensor::~ForceSensor() = default;
ForceSensor::ForceSensor(ForceSensor&&) noexcept = default;
ForceSensor& ForceSensor::operator=(ForceSensor&&) noexcept = default;

ForceSample ForceSensor::read(double time, double force) noexcept {
  State& s = *state_;
  const auto size = static_cast<long>(s.ring.size());
  // If the loop's period is longer than the sensor's, one sample is taken at its start.
  if (time + kSameTime >= static_cast<double>(s.taken) / s.options.rate) {
    const ForceSample sample{s.measured(force), time, s.taken};
    s.ring[s.taken % size] = sample;
    const long due = static_cast<long>(std::floor((time + kSameTime) * s.options.rate));
    for (long k = s.taken + 1; k <= due; ++k) {  // samples that were due since the last call repeat this one
      s.ring[k % size] = {sample.force, time, k};
    }
    s.taken = std::max(s.taken, due) + 1;
    s.arrived = std::max(s.arrived, s.taken - size);
  }
  while (s.arrived < s.taken) {
    const ForceSample& next = s.ring[s.arrived % size];
    if (next.time + s.options.delay > time + kSameTime) break;
    if (next.time < s.options.stale_from) {
      const bool stuck = next.time >= s.options.stuck_from && s.latest.number;
      const double since = next.time - s.options.jump_from;
      const double off = since >= 0.0 ? s.options.jump_by + since * s.options.drift : 0.0;
      s.latest = {stuck ? s.latest.force : next.force + off, next.time, next.number};
    }
    ++s.arrived;
  }
  return s.latest;
}

}  // namespace veridyn
