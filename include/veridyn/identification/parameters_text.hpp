#pragma once

#include <string>

#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// The base parameters with their deviations, the rank gap and the condition number, as text; beside
/// Identification::report(), which leaves them out.
std::string parameters_text(const Identification& id);

}  // namespace veridyn
