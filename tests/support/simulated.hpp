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

}  // namespace veridyn
