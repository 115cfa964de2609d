#pragma once

#include <string>

#include "veridyn/comparison/model_comparison.hpp"

namespace veridyn {

/// What `compare --json` writes: verdict, every parameter with its statistics and sentence, torques
/// per joint, what is not built alike. Joints count from 1.
std::string to_json(const ModelComparison& comparison);

}  // namespace veridyn
