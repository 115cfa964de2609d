#pragma once

#include <string>

#include "veridyn/excitation/excitation.hpp"
#include "veridyn/simulation/simulate_recording.hpp"

namespace veridyn {

/// What `veridyn excite --json` writes: quality, coefficients of the series, bounds and limits of
/// every joint.
std::string to_json(const Excitation& excitation);

/// The coefficients of the series as YAML, with what is needed to play the motion elsewhere.
std::string coefficients_yaml(const Excitation& excitation);

/// What `veridyn simulate --json` writes: hidden effects with their numbers, and how much noise the
/// torques got.
std::string to_json(const SimulatedRecording& simulated);

}  // namespace veridyn
