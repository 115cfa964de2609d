#pragma once

#include <string>
#include <vector>

#include "veridyn/simulation/control_loop.hpp"
#include "veridyn/simulation/simulate_recording.hpp"

namespace veridyn {

struct ControlledOptions {
  SimulationOptions recording;  ///< hidden effects and sensors; its tracking deviation is not used:
                                ///< the controller makes its own
  LoopOptions loop;             ///< empty gains: sensible_gains() of the arm with its effects;
                                ///< encoder steps and contacts come from `recording`
  std::string engine = "veridyn";
};

struct ControlledRecording {
  SimulatedRecording recording;  ///< up to where the run stopped
  EngineRun run;
  PidGains gains;                     ///< The gains that were used
  std::vector<std::string> left_out;  ///< effects that a forward simulation cannot have
};

/// Lets a PID lead an arm with values along a motion, and records it: forward dynamics, where
/// simulate_recording() takes the motion for granted.
/// @throws InvalidInput  as Plant, inject_effects() and run_with_pid().
ControlledRecording simulate_controlled(const Model& arm, const MotionSamples& wanted,
                                        const ControlledOptions& options);

}  // namespace veridyn
