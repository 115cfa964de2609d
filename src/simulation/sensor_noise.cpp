#include "veridyn/simulation/sensor_noise.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "math/random_numbers.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/model/suggestion.hpp"

namespace veridyn {
namespace {

constexpr int kWaves = 12;
constexpr double kSlowestWave = 0.05;  // [Hz]
constexpr double kFastestWave = 0.5;
constexpr double kFadeSeconds = 1.0;

// Streams of random numbers, one for each kind of noise and joint: changing one amount leaves the
// others as they were.
enum Stream : unsigned {
  kTracking = 100,
  kVelocity = 200,
  kTorqueWhite = 300,
  kTorqueColoured = 400,
  kStale = 500
};

RandomNumbers stream(unsigned seed, Stream kind, Eigen::Index joint) {
  return RandomNumbers(seed, kind + static_cast<unsigned>(joint));
}

double amount(const Model& arm, const JointAmount& of, Eigen::Index joint) {
  return arm.coordinates()[static_cast<size_t>(joint)].prismatic ? of.prismatic : of.revolute;
}

// A function of time with its first two derivatives.
struct Wave {
  Eigen::ArrayXd value, rate, bend;
};

Wave random_waves(const VectorXd& time, double rms, RandomNumbers& random) {
  const Eigen::ArrayXd zero = Eigen::ArrayXd::Zero(time.size());
  Wave sum{zero, zero, zero};
  const double size = rms * std::sqrt(2.0 / kWaves);
  for (int k = 0; k < kWaves; ++k) {
    const double omega = 2.0 * M_PI * random.uniform(kSlowestWave, kFastestWave);
    const double phase = random.uniform(0.0, 2.0 * M_PI);
    const Eigen::ArrayXd angle = omega * time.array() + phase;
    sum.value += size * angle.sin();
    sum.rate += size * omega * angle.cos();
    sum.bend -= size * omega * omega * angle.sin();
  }
  return sum;
}

// From 0 to 1 in the first second and back in the last one, without a jump up to the second
// derivative: 10 u^3 - 15 u^4 + 6 u^5. Shorter recordings spend half on each.
Wave fade_in_and_out(const VectorXd& time) {
  const Eigen::Index rows = time.size();
  const double end = time[rows - 1];
  const double length = std::min(kFadeSeconds, 0.5 * (end - time[0]));
  Wave fade{Eigen::ArrayXd::Ones(rows), Eigen::ArrayXd::Zero(rows), Eigen::ArrayXd::Zero(rows)};
  for (Eigen::Index k = 0; k < rows; ++k) {
    const bool starting = time[k] - time[0] < end - time[k];
    const double u = (starting ? time[k] - time[0] : end - time[k]) / length;
    if (!(u < 1.0)) continue;
    fade.value[k] = u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
    fade.rate[k] = (starting ? 30.0 : -30.0) * u * u * (1.0 - u) * (1.0 - u) / length;
    fade.bend[k] = 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / (length * length);
  }
  return fade;
}

void add_torque_noise(const SensorNoise& noise, unsigned seed, Eigen::Index joint,
                      const VectorXd& time, MatrixXd& tau) {
  const double rms = std::sqrt(tau.col(joint).squaredNorm() / static_cast<double>(tau.rows()));
  RandomNumbers white = stream(seed, kTorqueWhite, joint);
  RandomNumbers innovations = stream(seed, kTorqueColoured, joint);
  double coloured = innovations.normal();
  for (Eigen::Index k = 0; k < tau.rows(); ++k) {
    if (k > 0) {
      const double memory = std::exp(-(time[k] - time[k - 1]) / noise.colour_seconds);
      coloured = memory * coloured + std::sqrt(1.0 - memory * memory) * innovations.normal();
    }
    tau(k, joint) += rms * (noise.torque_white * white.normal() + noise.torque_coloured * coloured);
  }
}

}  // namespace

SensorNoise sensor_noise(const std::string& preset) {
  if (preset == "none") return {};
  if (preset == "low") return {{1e-3, 1e-4}, {1e-5, 1e-6}, {1e-3, 1e-4}, 0.005, 0.002, 0.1, 0.0};
  if (preset == "dvrk")
    return {{2e-3, 3e-4}, {7.72e-6, 1.29e-6}, {1e-2, 2e-3}, 0.03, 0.01, 0.1, 0.07};
  if (preset == "ur") return {{1e-3, 1e-4}, {1e-5, 1e-6}, {2e-3, 2e-4}, 0.06, 0.01, 0.1, 0.0};
  throw InvalidInput(text("found the noise preset '", preset, "'",
                          did_you_mean(preset, sensor_noise_names()),
                          ", expected one of: ", listed(sensor_noise_names()), "."));
}

const std::vector<std::string>& sensor_noise_names() {
  static const std::vector<std::string> names{"none", "low", "dvrk", "ur"};
  return names;
}

std::string describe(const SensorNoise& noise) {
  return fmt::format(
      "tracking {:g} mrad / {:g} mm, encoder step {:g} mrad / {:g} mm, velocity {:g} mrad/s / {:g} "
      "mm/s, torque {:g} % "
      "white and {:g} % coloured ({:g} s) of its rms, {:g} % stale rows",
      1e3 * noise.tracking.revolute, 1e3 * noise.tracking.prismatic,
      1e3 * noise.encoder_step.revolute, 1e3 * noise.encoder_step.prismatic,
      1e3 * noise.velocity.revolute, 1e3 * noise.velocity.prismatic, 100 * noise.torque_white,
      100 * noise.torque_coloured, noise.colour_seconds, 100 * noise.stale_rows);
}

MotionSamples with_tracking_deviation(const Model& arm, const MotionSamples& wanted,
                                      const SensorNoise& noise, unsigned seed) {
  MotionSamples actual = wanted;
  const Wave fade = fade_in_and_out(wanted.time);
  for (Eigen::Index i = 0; i < wanted.joints(); ++i) {
    const double rms = amount(arm, noise.tracking, i);
    if (rms == 0.0 || wanted.dq.col(i).cwiseAbs().maxCoeff() == 0.0) continue;
    RandomNumbers random = stream(seed, kTracking, i);
    const Wave d = random_waves(wanted.time, rms, random);
    actual.q.col(i).array() += fade.value * d.value;
    actual.dq.col(i).array() += fade.rate * d.value + fade.value * d.rate;
    actual.ddq.col(i).array() +=
        fade.bend * d.value + 2.0 * fade.rate * d.rate + fade.value * d.bend;
  }
  return actual;
}

void measure(const Model& arm, const SensorNoise& noise, unsigned seed, MotionSamples& motion,
             MatrixXd& tau) {
  for (Eigen::Index i = 0; i < motion.joints(); ++i) {
    const double step = amount(arm, noise.encoder_step, i);
    if (step > 0.0) motion.q.col(i) = (motion.q.col(i).array() / step).round() * step;
    const double velocity = amount(arm, noise.velocity, i);
    RandomNumbers random = stream(seed, kVelocity, i);
    if (velocity > 0.0) {
      for (double& v : motion.dq.col(i)) v += velocity * random.normal();
    }
    if (noise.torque_white > 0.0 || noise.torque_coloured > 0.0)
      add_torque_noise(noise, seed, i, motion.time, tau);
  }
  RandomNumbers random = stream(seed, kStale, 0);
  for (Eigen::Index k = 1; k < motion.rows(); ++k) {
    if (!(random.uniform() < noise.stale_rows)) continue;
    motion.q.row(k) = motion.q.row(k - 1);
    motion.dq.row(k) = motion.dq.row(k - 1);
    tau.row(k) = tau.row(k - 1);
  }
}

}  // namespace veridyn
