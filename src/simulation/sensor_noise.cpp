#include "veridyn/simulation/sensor_noise.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "math/random_numbers.hpp"
#include "veridyn/simulation/resampled_motion.hpp"

namespace veridyn {
namespace {

constexpr int kWaves = 12;
constexpr double kSlowestWave = 0.05;  // [Hz] lowest frequency of the tracking deviation
constexpr double kFastestWave = 0.5;
constexpr double kFadeSeconds = 1.0;

// Streams of random numbers, one for each kind of noise and joint, so that changing one amount
// leaves the others unchanged.
enum Stream : unsigned {
  kTracking = 100,
  kVelocity = 200,
  kTorqueWhite = 300,
  kTorqueColoured = 400,
  kStale = 500,
  kLate = 600,
  kDropouts = 700
};

RandomNumbers random_stream(unsigned seed, Stream kind, Eigen::Index joint) {
  return RandomNumbers(seed, kind + static_cast<unsigned>(joint));
}

double amount_for_joint(const Model& arm, const JointAmount& of, Eigen::Index joint) {
  return arm.coordinates()[joint].prismatic ? of.prismatic : of.revolute;
}

// A function of time with its first two derivatives.
struct Wave {
  Eigen::ArrayXd value, rate, bend;
};

// A sum of kWaves sines of random frequency and phase with this root mean square.
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

// A factor that rises from 0 to 1 in the first second and falls back in the last one, smooth up to the second
// derivative: 10 u^3 - 15 u^4 + 6 u^5. In shorter recordings each of the two takes half of the duration.
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

// Adds white and coloured noise to a joint's torques, in proportion to their rms.
void add_torque_noise(const SensorNoise& noise, unsigned seed, Eigen::Index joint,
                      const VectorXd& time, MatrixXd& tau) {
  const double rms = std::sqrt(tau.col(joint).squaredNorm() / static_cast<double>(tau.rows()));
  RandomNumbers white = random_stream(seed, kTorqueWhite, joint);
  RandomNumbers innovations = random_stream(seed, kTorqueColoured, joint);
  double coloured = innovations.normal();
  for (Eigen::Index k = 0; k < tau.rows(); ++k) {
    if (k > 0) {
      const double memory = std::exp(-(time[k] - time[k - 1]) / noise.colour_seconds);
      coloured = memory * coloured + std::sqrt(1.0 - memory * memory) * innovations.normal();
    }
    tau(k, joint) += rms * (noise.torque_white * white.normal() + noise.torque_coloured * coloured);
  }
}

// Replaces the values of every row by those shortly before its time.
void delay_rows(const SensorNoise& noise, unsigned seed, MotionSamples& motion, MatrixXd& tau) {
  const VectorXd time = motion.time;
  VectorXd shown = time;
  RandomNumbers random = random_stream(seed, kLate, 0);
  for (Eigen::Index k = 0; k < time.size(); ++k) {
    shown[k] -= noise.delay + noise.late * std::abs(random.normal());
    // The instant of a row is never before that of the previous row.
    shown[k] = std::max(shown[k], k > 0 ? shown[k - 1] : time[0]);
  }
  motion = motion_at(motion, shown);
  motion.time = time;
  const MatrixXd true_tau = tau;
  Eigen::Index from = 0;
  for (Eigen::Index k = 0; k < time.size(); ++k) {
    while (from + 1 < time.size() && time[from + 1] <= shown[k]) ++from;
    const Eigen::Index to = std::min(from + 1, time.size() - 1);
    const double u = to > from ? (shown[k] - time[from]) / (time[to] - time[from]) : 0.0;
    tau.row(k) = (1.0 - u) * true_tau.row(from) + u * true_tau.row(to);
  }
}

// Rows of a fault that occurs in runs of a given mean length and affects a given share of all rows.
class Runs {
 public:
  Runs(double share, double length, RandomNumbers random)
      : stays_(1.0 - 1.0 / length), random_(std::move(random)) {
    // Probabilities per row, whose stationary share is begins / (begins + ends).
    begins_ = length > 1.0 ? share / (length * (1.0 - share)) : share;
    if (length == 1.0) stays_ = share;  // isolated rows
  }

  bool next_row_is_inside() {
    inside_ = random_.uniform() < (inside_ ? stays_ : begins_);
    return inside_;
  }

 private:
  double stays_, begins_ = 0.0;
  RandomNumbers random_;
  bool inside_ = false;
};

}  // namespace

MotionSamples with_tracking_deviation(const Model& arm, const MotionSamples& wanted,
                                      const SensorNoise& noise, unsigned seed) {
  MotionSamples actual = wanted;
  const Wave fade = fade_in_and_out(wanted.time);
  for (Eigen::Index i = 0; i < wanted.joints(); ++i) {
    const double rms = amount_for_joint(arm, noise.tracking, i);
    if (rms == 0.0 || wanted.dq.col(i).cwiseAbs().maxCoeff() == 0.0) continue;
    RandomNumbers random = random_stream(seed, kTracking, i);
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
  if (noise.delay > 0.0 || noise.late > 0.0) delay_rows(noise, seed, motion, tau);
  for (Eigen::Index i = 0; i < motion.joints(); ++i) {
    const double step = amount_for_joint(arm, noise.encoder_step, i);
    if (step > 0.0) motion.q.col(i) = (motion.q.col(i).array() / step).round() * step;
    const double velocity = amount_for_joint(arm, noise.velocity, i);
    RandomNumbers random = random_stream(seed, kVelocity, i);
    if (velocity > 0.0) {
      for (double& v : motion.dq.col(i)) v += velocity * random.normal();
    }
    if (noise.torque_white > 0.0 || noise.torque_coloured > 0.0)
      add_torque_noise(noise, seed, i, motion.time, tau);
  }
  Runs stale(noise.stale_rows, noise.stale_run, random_stream(seed, kStale, 0));
  for (Eigen::Index k = 1; k < motion.rows(); ++k) {
    if (!stale.next_row_is_inside()) continue;
    motion.q.row(k) = motion.q.row(k - 1);
    motion.dq.row(k) = motion.dq.row(k - 1);
    tau.row(k) = tau.row(k - 1);
  }
  Runs missing(noise.dropouts, noise.dropout_run, random_stream(seed, kDropouts, 0));
  for (Eigen::Index k = 1; k < motion.rows(); ++k) {
    if (!missing.next_row_is_inside()) continue;
    for (MatrixXd* m : {&motion.q, &motion.dq, &tau})
      m->row(k).setConstant(std::numeric_limits<double>::quiet_NaN());
  }
}

}  // namespace veridyn
