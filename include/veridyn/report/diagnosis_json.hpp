#pragma once

#include <string>

#include "veridyn/diagnosis/diagnosis.hpp"
#include "veridyn/diagnosis/friction_study.hpp"

namespace veridyn {

/// What `diagnose --json` writes; keys as in CONTRACT.md.
/// @param next_command  as in Diagnosis::report(); it stands under next_experiment.trajectory.
std::string to_json(const Diagnosis& diagnosis, const std::string& next_command = "");

/// What `friction --json` writes.
std::string to_json(const FrictionStudy& study);

}  // namespace veridyn
