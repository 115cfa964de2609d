#pragma once

#include "identification/fleet/fleet_solver.hpp"

namespace veridyn {

/// How every own value and gain spreads over the arms of the fleet, and the arms that are far off.
void add_spreads(const Model& arm, const FleetSolver& solver, Fleet& fleet);

}  // namespace veridyn
