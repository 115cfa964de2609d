#pragma once

#include <string>

#include "veridyn/excitation/excitation.hpp"
#include "veridyn/simulation/breakaway.hpp"
#include "veridyn/simulation/simulate_controlled.hpp"

namespace veridyn {

/// JSON of `veridyn excite --json`: quality, coefficients of the Fourier series, bounds and limits
/// of every joint.
std::string to_json(const Excitation& excitation);

/// The coefficients of the Fourier series as YAML, sufficient to replay the motion elsewhere.
std::string coefficients_yaml(const Excitation& excitation);

/// JSON of `veridyn simulate --json`: hidden effects with their numbers, and the noise of the
/// torques.
std::string to_json(const SimulatedRecording& simulated);

/// JSON of a simulation with a controller: in addition gains, largest deviation from the wanted
/// motion, and whether the run was complete.
std::string to_json(const ControlledRecording& controlled, const MotionSamples& wanted);

/// JSON of `veridyn simulate --replay --json`: errors of torque and motion per joint.
std::string to_json(const Replay& replay, const Model& arm);

/// JSON of `veridyn simulate --breakaway --json`: every ramp, and the medians.
std::string to_json(const Breakaway& found, const Model& arm);

}  // namespace veridyn
