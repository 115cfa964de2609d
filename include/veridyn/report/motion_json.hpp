#pragma once

#include <string>

#include "veridyn/excitation/excitation.hpp"
#include "veridyn/simulation/replay.hpp"
#include "veridyn/simulation/simulate_controlled.hpp"

namespace veridyn {

/// What `veridyn excite --json` writes: quality, coefficients of the series, bounds and limits of
/// every joint.
std::string to_json(const Excitation& excitation);

/// What `veridyn simulate --json` writes: hidden effects with their numbers, and how much noise the
/// torques got.
std::string to_json(const SimulatedRecording& simulated);

/// With a controller: the same, and gains, largest deviation from the wanted motion, and whether
/// the run came to its end.
std::string to_json(const ControlledRecording& controlled, const MotionSamples& wanted);

/// What `veridyn simulate --replay --json` writes: errors of torque and motion per joint.
std::string to_json(const Replay& replay, const Model& arm);

}  // namespace veridyn
