#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "dvrk/run/arm_run.hpp"
#include "dvrk/protocol/fault_log.hpp"

namespace veridyn::dvrk {

/// JSON of a client's command: rows, reason for the end, timing of the loop [s], every condition of
/// section 17 that occurred, with its number.
std::string to_json(const RunResult& run, const FaultLog& faults, const std::string& command,
                    const std::string& arm);

/// Counters of a command, by name.
std::string to_json(const std::vector<std::pair<std::string, std::int64_t>>& counts,
                    const std::string& command, const std::string& arm);

}  // namespace veridyn::dvrk
