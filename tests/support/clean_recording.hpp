#pragma once

#include <cmath>
#include <random>

#include "veridyn/recordings/recording.hpp"

namespace veridyn {

constexpr double kCleanRate = 200.0;  ///< [Hz]
constexpr int kCleanRows = 6000;
constexpr int kCleanJoints = 3;

/// A flawless recording: three joints in motion that does not repeat, noise of encoders and torques.
inline Recording clean_recording(unsigned seed = 17) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Recording r;
  r.source = "clean";
  r.time.resize(kCleanRows);
  r.q.resize(kCleanRows, kCleanJoints);
  r.dq.resize(kCleanRows, kCleanJoints);
  r.tau.resize(kCleanRows, kCleanJoints);
  const double frequency[4] = {0.7, 1.3, 2.1, 3.7};  // [rad/s] no common period
  for (int k = 0; k < kCleanRows; ++k) {
    r.time[k] = k / kCleanRate;
    for (int j = 0; j < kCleanJoints; ++j) {
      double q = 0.0, dq = 0.0, ddq = 0.0;
      for (int h = 0; h < 4; ++h) {
        const double w = frequency[h] * (1.0 + 0.13 * j);
        const double phase = w * r.time[k] + h + 2 * j;
        q += 0.2 * std::sin(phase);
        dq += 0.2 * w * std::cos(phase);
        ddq -= 0.2 * w * w * std::sin(phase);
      }
      r.q(k, j) = q + 1e-5 * normal(random);
      r.dq(k, j) = dq + 2e-3 * normal(random);
      r.tau(k, j) =
          0.4 * ddq + 0.3 * dq + 0.2 * std::tanh(50.0 * dq) + std::sin(q) + 5e-3 * normal(random);
    }
  }
  return r;
}

}  // namespace veridyn
