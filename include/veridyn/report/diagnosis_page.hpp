#pragma once

#include <string>

#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn {

/// What `diagnose --report` writes: one HTML file that needs neither a network nor other files,
/// with the verdict in words, errors and findings in tables, torques over time, residuals against
/// the motion, what each finding gains, what was ruled out, and what it takes to repeat the run.
///
/// Every number in its text is one of to_json(), which stands in the page as the element "result".
/// @param command  the command line of the run, shown as it is; empty: none.
/// @param next_command  as in Diagnosis::report().
std::string to_page(const Diagnosis& diagnosis, const std::string& command = "",
                    const std::string& next_command = "");

}  // namespace veridyn
