#pragma once

#include <string>

#include "veridyn/excitation/excitation.hpp"
#include "veridyn/simulation/breakaway.hpp"
#include "veridyn/simulation/simulate_controlled.hpp"

namespace veridyn {

/// What `veridyn excite --json` writes: quality, coefficients of the series, bounds and limits of
/// every joint.
std::string to_json(const Excitation& excitation);

/// The coefficients of the series as YAML, with what is needed to play the motion elsewhere.
std::string coefficients_yaml(const Excitation& excitation);

/// What `veridyn simulate --json` writes: hidden effects with their numbers, and how much noise the
/// torques got.
std::string to_json(const SimulatedRecording& simulated);

/// With a controller: the same, and gains, largest deviation from the wanted motion, and whether
/// the run came to its end.
std::string to_json(const ControlledRecording& controlled, const MotionSamples& wanted);

/// What `veridyn simulate --replay --json` writes: errors of torque and motion per joint.
std::string to_json(const Replay& replay, const Model& arm);

/// What `veridyn simulate --breakaway --json` writes: every ramp, and the medians.
std::string to_json(const Breakaway& found, const Model& arm);

}  // namespace veridyn
