#pragma once

#include <string>

#include "veridyn/simulation/breakaway.hpp"
#include "veridyn/simulation/simulate_controlled.hpp"

namespace veridyn {

/// Texts of a page in addition to its result.
struct SimulationRun {
  std::string source;   ///< the recording or trajectory that drove the run
  std::string command;  ///< the command line, shown verbatim; empty: none
  std::string report;   ///< the result as plain text, for a reader without scripts
};

/// Page of `simulate --report`: one HTML file that needs neither a network nor other files, with
/// errors per joint in tables, and motion, torques and their errors over time. For an incomplete
/// run it shows the time and the joint of the failure.
///
/// Every number in its text comes from to_json(), which the page contains as the element "result".
std::string to_page(const Replay& replay, const Model& arm, const ReplayInput& input,
                    const SimulationRun& run);

/// Page of a trajectory under a controller.
std::string to_page(const ControlledRecording& controlled, const MotionSamples& wanted,
                    const SimulationRun& run);

/// Page of breakaway ramps: displacement over effort, recorded and simulated, and the efforts at
/// the onset of sliding.
std::string to_page(const Breakaway& found, const Model& arm, const ReplayInput& input,
                    const SimulationRun& run);

}  // namespace veridyn
