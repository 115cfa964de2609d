#pragma once

#include <string>

#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// The base parameters with their deviations, the rank gap and the condition number, as text;
/// Identification::report() does not contain them.
std::string parameters_text(const Identification& id);

}  // namespace veridyn
