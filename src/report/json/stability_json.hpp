#pragma once

#include <string>

#include "veridyn/cooperation/stability.hpp"

namespace veridyn {

/// What `stability --json` writes: eigenvalues, stable, margins, largest_stable_stiffness, points,
/// and map, locus, recommendation and bounds where they were asked for. Margins that were not found
/// are null.
std::string to_json(const StabilityStudy& study);

/// The same as one HTML page, with eigenvalues, locus, map and step responses drawn.
/// @param command  the command line that made it.
std::string to_page(const StabilityStudy& study, const std::string& command);

}  // namespace veridyn
