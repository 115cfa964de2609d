#pragma once

#include <string>

#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn {

/// Contradictions between recordings and robot file, and whether the results are of recordings and file with these corrected: "...
/// With that: " or "... As recorded: "; empty where there is none.
std::string mistakes_text(const Diagnosis& d);

}  // namespace veridyn
