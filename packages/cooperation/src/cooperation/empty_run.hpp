#pragma once

#include "veridyn/cooperation/scenario_run.hpp"

namespace veridyn {

/// A run with its names and `rows` rows of zeros.
ScenarioRun empty_run(const Scenario& scenario, const std::string& engine, Eigen::Index rows);

/// Truncates a run to its first rows.
void keep_first_rows(ScenarioRun& run, Eigen::Index rows);

}  // namespace veridyn
