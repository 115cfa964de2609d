#pragma once

#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn {

/// diagnose() of a robot. @param fitted  its identification from the same recordings with the same
/// preprocessing, or null: then it is computed here.
Diagnosis diagnose(const Model& arm, const Recordings& train, const Recordings& test,
                   const DiagnosisOptions& options, const Identification* fitted);

}  // namespace veridyn
