#pragma once

#include <string>

#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn {

/// Marks the main findings, lists them first, and computes the share of the error that they explain.
void summarize(Diagnosis& d, const DiagnosisOptions& options);

/// Contradictions between recordings and robot file, and whether the results are those of mended ones: "...
/// With that: " or "... As recorded: "; empty where there is none.
std::string mistakes_text(const Diagnosis& d);

}  // namespace veridyn
