#pragma once

#include "veridyn/cooperation/scenario_run.hpp"

namespace veridyn {

/// A run with room for so many rows.
ScenarioRun empty_run(const Scenario& scenario, const std::string& engine, Eigen::Index rows);

/// Keeps the first rows alone.
void keep_first_rows(ScenarioRun& run, Eigen::Index rows);

}  // namespace veridyn
