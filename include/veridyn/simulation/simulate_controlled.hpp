#pragma once

#include <string>
#include <vector>

#include "veridyn/simulation/control_loop.hpp"
#include "veridyn/simulation/simulate_recording.hpp"

namespace veridyn {

struct ControlledOptions {
  /// Hidden effects and sensors; its tracking deviation is not used, because the controller has its
  /// own.
  SimulationOptions recording;
  /// Options of the loop. If its gains are empty, they are sensible_gains() of the arm without the hidden
  /// effects; encoder steps and contacts come from `recording`.
  LoopOptions loop;
  std::string engine = "veridyn";
};

struct ControlledRecording {
  SimulatedRecording recording;  ///< recording up to the end of the run
  EngineRun run;
  PidGains gains;                     ///< gains of the run
  std::vector<std::string> left_out;  ///< effects that a forward simulation does not support
};

/// Simulates a PID that moves an arm with values along a motion, and records it: forward dynamics,
/// whereas simulate_recording() prescribes the motion.
/// @throws InvalidInput  as Plant, inject_effects() and run_with_pid().
ControlledRecording simulate_controlled(const Model& arm, const MotionSamples& wanted,
                                        const ControlledOptions& options);

}  // namespace veridyn
