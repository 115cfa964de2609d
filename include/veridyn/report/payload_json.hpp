#pragma once

#include <string>

#include "veridyn/diagnosis/payload.hpp"

namespace veridyn {

/// JSON of `payload --json`.
std::string to_json(const PayloadReport& report);

}  // namespace veridyn
