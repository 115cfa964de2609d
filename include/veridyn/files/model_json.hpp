#pragma once

#include <string>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// A robot file as JSON: the same keys as in YAML, arithmetic evaluated, infinite numbers as
/// ".inf". read_model() reads it.
std::string model_json(const Model& arm);

/// Writes model_json() to a file. @throws InvalidInput  the file cannot be written.
void save_model_json(const Model& arm, const std::string& path);

}  // namespace veridyn
