#pragma once

#include <string>

#include "veridyn/excitation/excitation.hpp"

namespace veridyn {

/// What `excite --report` writes: one HTML file that needs neither a network nor other files, with
/// the motion, every limit with its margin, and what a recording of it will identify.
///
/// Every number in its text is one of to_json(), which stands in the page as the element "result".
/// @param command  the command line of the run, shown as it is; empty: none.
/// @throws InvalidInput  the excitation has no motion.
std::string to_page(const Excitation& excitation, const std::string& command = "");

}  // namespace veridyn
