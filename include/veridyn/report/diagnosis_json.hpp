#pragma once

#include <string>

#include "veridyn/diagnosis/diagnosis.hpp"
#include "veridyn/diagnosis/friction_study.hpp"

namespace veridyn {

/// JSON of `diagnose --json`; keys as in docs/contract.md.
/// @param next_command  as in Diagnosis::report(); the key is next_experiment.trajectory.
std::string to_json(const Diagnosis& diagnosis, const std::string& next_command = "");

/// What `friction --json` writes.
std::string to_json(const FrictionStudy& study);

}  // namespace veridyn
