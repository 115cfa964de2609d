#pragma once

#include <string>

#include "veridyn/simulation/breakaway.hpp"
#include "veridyn/simulation/simulate_controlled.hpp"

namespace veridyn {

/// What a page says about the run beside its result.
struct SimulationRun {
  std::string source;   ///< the file that led: a recording or a trajectory
  std::string command;  ///< the command line, shown as it is; empty: none
  std::string report;   ///< the result as plain text, for a reader without scripts
};

/// What `simulate --report` writes: one HTML file that needs neither a network nor other files,
/// with errors per joint in tables, and over time the motion, the torques and what is left of both.
/// A run that stopped says so, with the time and the joint.
///
/// Every number in its text is one of to_json(), which stands in the page as the element "result".
std::string to_page(const Replay& replay, const Model& arm, const ReplayInput& input,
                    const SimulationRun& run);

/// The same for a trajectory under a controller.
std::string to_page(const ControlledRecording& controlled, const MotionSamples& wanted,
                    const SimulationRun& run);

/// Ramps of force: the way over the effort, recorded and simulated, and the efforts at which the
/// joint began to slide.
std::string to_page(const Breakaway& found, const Model& arm, const ReplayInput& input,
                    const SimulationRun& run);

}  // namespace veridyn
