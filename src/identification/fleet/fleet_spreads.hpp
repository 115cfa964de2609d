#pragma once

#include "identification/fleet/fleet_solver.hpp"

namespace veridyn {

/// Adds the spread of every own value and gain over the fleet, and the outliers.
void add_spreads(const Model& arm, const FleetSolver& solver, Fleet& fleet);

}  // namespace veridyn
