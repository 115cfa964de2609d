#pragma once

#include "veridyn/simulation/simulate_recording.hpp"

namespace veridyn {

/// From what an arm did (out.actual, out.actual_tau) to what its sensors say (out.measured,
/// out.tau): encoder offset, gain and delay of the torque, noise.
void record(const Model& arm, const PerturbedArm& plant, const SimulationOptions& options,
            SimulatedRecording& out);

}  // namespace veridyn
