#pragma once

#include <string>

#include "veridyn/cooperation/scenario_run.hpp"
#include "veridyn/cooperation/scenario_sweep.hpp"

namespace veridyn {

/// What `cooperate --json` writes: the scenario's loops, figures of every phase and member beside
/// what was asked, how it ended.
std::string to_json(const ScenarioRun& run, const Scenario& scenario);

/// What `cooperate --sweep --json` writes: every point of the map, and the stable region.
std::string to_json(const ScenarioSweepResult& sweep, const Scenario& scenario);

/// The same as one HTML page, with plots over time, or the map.
/// @param command  the command line that made it.
std::string to_page(const ScenarioRun& run, const Scenario& scenario, const std::string& command);
std::string to_page(const ScenarioSweepResult& sweep, const Scenario& scenario,
                    const std::string& command);

}  // namespace veridyn
