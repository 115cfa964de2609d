#pragma once

#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn {

/// diagnose() of a robot. @param fitted  its identification from these recordings, prepared alike, or null: it is then
/// made here.
Diagnosis diagnose(const Model& arm, const Recordings& train, const Recordings& test,
                   const DiagnosisOptions& options, const Identification* fitted);

}  // namespace veridyn
