#pragma once

#include "veridyn/cooperation/scenario_run.hpp"

namespace veridyn {

/// Figures of a phase from the rows [first, end) of a run.
PhaseFigures phase_figures(const Scenario& scenario, const ScenarioPhase& phase,
                           const ScenarioRun& run, Eigen::Index first, Eigen::Index end);

}  // namespace veridyn
