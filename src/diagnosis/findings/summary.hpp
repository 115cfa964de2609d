#pragma once

#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn {

/// Marks the main findings, puts them first, and counts what they explain.
void summarize(Diagnosis& d, const DiagnosisOptions& options);

}  // namespace veridyn
