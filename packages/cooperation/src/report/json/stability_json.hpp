#pragma once

#include <string>

#include "veridyn/cooperation/stability.hpp"

namespace veridyn {

/// JSON of `stability --json`: eigenvalues, stable, margins, largest_stable_stiffness, points, and
/// map, locus, recommendation and bounds on request. Margins that were not found are null.
std::string to_json(const StabilityStudy& study);

/// The same as one HTML page, with eigenvalues, locus, map and step responses drawn.
/// @param command  command line of the run.
std::string to_page(const StabilityStudy& study, const std::string& command);

}  // namespace veridyn
