#pragma once

#include "veridyn/simulation/simulate_recording.hpp"

namespace veridyn {

/// Turns the true motion (out.actual, out.actual_tau) into the recorded one (out.measured,
/// out.tau): encoder offset, gain and delay of the torque, noise.
void record(const Model& arm, const PerturbedArm& plant, const SimulationOptions& options,
            SimulatedRecording& out);

}  // namespace veridyn
