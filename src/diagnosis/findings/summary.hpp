#pragma once

#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn {

/// Marks the main findings, lists them first, and computes the share of the error that they explain.
void summarize(Diagnosis& d, const DiagnosisOptions& options);

}  // namespace veridyn
