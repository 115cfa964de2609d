#pragma once

#include <string>

#include "veridyn/cooperation/scenario_run.hpp"
#include "veridyn/cooperation/scenario_sweep.hpp"

namespace veridyn {

/// JSON of `cooperate --json`: the scenario's loops, results of every phase and member with their
/// bounds, and the end of the run.
std::string to_json(const ScenarioRun& run, const Scenario& scenario);

/// JSON of `cooperate --sweep --json`: every point of the map, and the stable region.
std::string to_json(const ScenarioSweepResult& sweep, const Scenario& scenario);

/// The same as one HTML page, with plots over time, or the map.
/// @param command  command line of the run.
std::string to_page(const ScenarioRun& run, const Scenario& scenario, const std::string& command);
std::string to_page(const ScenarioSweepResult& sweep, const Scenario& scenario,
                    const std::string& command);

}  // namespace veridyn
