#pragma once

#include <string>

#include "veridyn/diagnosis/payload.hpp"

namespace veridyn {

/// What `payload --json` writes.
std::string to_json(const PayloadReport& report);

}  // namespace veridyn
