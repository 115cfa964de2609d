#pragma once

#include <string>

#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn {

/// What `diagnose --json` writes; keys as in CONTRACT.md.
std::string to_json(const Diagnosis& diagnosis);

}  // namespace veridyn
