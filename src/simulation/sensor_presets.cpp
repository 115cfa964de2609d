#include <fmt/format.h>


#include "files/words.hpp"
#include "veridyn/math/require.hpp"
#include "files/expression.hpp"
#include "model/suggestion.hpp"
#include "veridyn/simulation/sensor_noise.hpp"

namespace veridyn {
namespace {

struct Key {
  const char* name;
  double SensorNoise::*amount;
  double lower, upper;
};

constexpr double kAnyAmount = 1e3;

const std::vector<Key>& noise_keys() {
  static const std::vector<Key> all{
      {"torque_white", &SensorNoise::torque_white, 0.0, kAnyAmount},
      {"torque_coloured", &SensorNoise::torque_coloured, 0.0, kAnyAmount},
      {"delay", &SensorNoise::delay, 0.0, kAnyAmount},
      {"late", &SensorNoise::late, 0.0, kAnyAmount},
      {"stale_rows", &SensorNoise::stale_rows, 0.0, 0.9},
      {"stale_run", &SensorNoise::stale_run, 1.0, kAnyAmount},
      {"dropouts", &SensorNoise::dropouts, 0.0, 0.9},
      {"dropout_run", &SensorNoise::dropout_run, 1.0, kAnyAmount}};
  return all;
}

SensorNoise preset_of(const std::string& name) {
  if (name == "none") return {};
  SensorNoise noise;
  if (name == "low") {
    noise.tracking = {1e-3, 1e-4};
    noise.encoder_step = {1e-5, 1e-6};
    noise.velocity = {1e-3, 1e-4};
    noise.torque_white = 0.005;
    noise.torque_coloured = 0.002;
    return noise;
  }
  if (name == "dvrk" || name == "dvrk-late") {
    noise.tracking = {2e-3, 3e-4};
    noise.encoder_step = {7.72e-6, 1.29e-6};
    noise.velocity = {1e-2, 2e-3};
    noise.torque_white = 0.03;
    noise.torque_coloured = 0.01;
    noise.stale_rows = 0.07;
    if (name == "dvrk") return noise;
    noise.stale_rows = 0.12;
    noise.stale_run = 1.4;
    noise.late = 1.9e-3;
    return noise;
  }
  if (name == "ur") {
    noise.tracking = {1e-3, 1e-4};
    noise.encoder_step = {1e-5, 1e-6};
    noise.velocity = {2e-3, 2e-4};
    noise.torque_white = 0.06;
    noise.torque_coloured = 0.01;
    return noise;
  }
  throw InvalidInput(text("found the noise preset '", name, "'",
                          did_you_mean(name, sensor_noise_names()),
                          ", expected one of: ", listed(sensor_noise_names()), "."));
}

// Sets the amount of "KEY=VALUE"; throws InvalidInput for an unknown key or a value out of range.
void change(const std::string& pair, SensorNoise& noise) {
  const auto equals = pair.find('=');
  const std::string name = pair.substr(0, equals);
  std::vector<std::string> names;
  for (const Key& key : noise_keys()) {
    names.emplace_back(key.name);
    if (name != key.name || equals == std::string::npos) continue;
    const double value = evaluate(pair.substr(equals + 1), {});
    require(value >= key.lower && value <= key.upper, "noise: found ", name, " = ", value,
            ", expected ", key.lower, " to ", key.upper, ".");
    noise.*key.amount = value;
    return;
  }
  throw InvalidInput(text("noise: found '", pair, "'", did_you_mean(name, names),
                          ", expected KEY=VALUE with one of: ", listed(names), "."));
}

}  // namespace

SensorNoise sensor_noise(const std::string& asked) {
  const auto colon = asked.find(':');
  SensorNoise noise = preset_of(asked.substr(0, colon));
  if (colon == std::string::npos) return noise;
  for (const std::string& pair : split(asked.substr(colon + 1), ',')) change(pair, noise);
  return noise;
}

const std::vector<std::string>& sensor_noise_names() {
  static const std::vector<std::string> names{"none", "low", "dvrk", "dvrk-late", "ur"};
  return names;
}

std::string describe(const SensorNoise& noise) {
  std::string out = fmt::format(
      "tracking {:g} mrad / {:g} mm, encoder step {:g} mrad / {:g} mm, velocity {:g} mrad/s / {:g} "
      "mm/s, torque {:g} % "
      "white and {:g} % coloured ({:g} s) of its rms, {:g} % stale rows",
      1e3 * noise.tracking.revolute, 1e3 * noise.tracking.prismatic,
      1e3 * noise.encoder_step.revolute, 1e3 * noise.encoder_step.prismatic,
      1e3 * noise.velocity.revolute, 1e3 * noise.velocity.prismatic, 100 * noise.torque_white,
      100 * noise.torque_coloured, noise.colour_seconds, 100 * noise.stale_rows);
  if (noise.stale_run > 1.0) out += fmt::format(" in runs of {:g}", noise.stale_run);
  if (noise.late > 0.0) out += fmt::format(", rows {:g} ms late", 1e3 * noise.late);
  return out;
}

}  // namespace veridyn
