#pragma once

#include <optional>

#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// Values for a body in the manufacturer's file.
std::optional<InertialParameters> manufacturer_values(const Model& arm, const Body& body);

/// @throws InvalidInput  the prior of the options lacks values, or its bodies differ from those of the arm.
void require_prior_fits(const Model& arm, const IdentificationOptions& options);

/// Feasible least squares on a factor over all standard parameters, with the signs and boxes of the robot
/// file and the prior of the options. Sets parameters, objective, gap, active constraints, and a status
/// with its reason where there is no solution.
void solve_feasible(const Model& arm, const SquareRootInformation& total,
                    const IdentificationOptions& options, Identification& id);

}  // namespace veridyn
