#pragma once

#include <string>

#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// What `identify --report` writes: one HTML file that needs neither a network nor other files,
/// with errors per joint and their noise floor, torques over time, residuals against the motion,
/// base parameters with standard deviations, and settings.
///
/// Every number in its text is one of to_json(), which stands in the page as the element "result".
/// @param command  the command line of the run, shown as it is; empty: none.
std::string to_page(const Identification& id, const std::string& command = "");

}  // namespace veridyn
