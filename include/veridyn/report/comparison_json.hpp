#pragma once

#include <string>

#include "veridyn/diagnosis/model_comparison.hpp"

namespace veridyn {

/// JSON of `compare --json`: verdict, every parameter with its statistics and sentence, torques per
/// joint, structural differences. Joints count from 1.
std::string to_json(const ModelComparison& comparison);

}  // namespace veridyn
