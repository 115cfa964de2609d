#pragma once

#include <string>

#include "veridyn/recordings/recording.hpp"
#include "veridyn/simulation/simulate_recording.hpp"

namespace veridyn {

/// What a simulation recorded, as it would be read back from a file.
inline Recording recording_of(const SimulatedRecording& s) {
  Recording r;
  r.source = "simulated";
  r.time = s.measured.time;
  r.q = s.measured.q;
  r.dq = s.measured.dq;
  r.tau = s.tau;
  return r;
}

/// Forty seconds of waves of two joints; those of other seeds differ in frequency and phase.
inline MotionSamples waves_of(unsigned seed) {
  MotionSamples m{VectorXd::LinSpaced(4000, 0.0, 39.99), MatrixXd(4000, 2), {}, {}};
  for (int i = 0; i < 2; ++i)
    m.q.col(i) = 0.3 + 0.6 * ((1.1 + 0.23 * i + 0.1 * seed) * m.time.array() + i * (1.0 + seed)).sin() +
                 0.3 * ((2.9 - 0.31 * i) * m.time.array()).cos();
  return with_derivatives(m);
}

}  // namespace veridyn
