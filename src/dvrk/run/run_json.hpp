#pragma once

#include <string>

#include "dvrk/run/arm_run.hpp"
#include "dvrk/emulator/board_emulator.hpp"
#include "dvrk/protocol/fault_log.hpp"

namespace veridyn::dvrk {

/// What a client's command did: rows, why it ended, timing of the loop [s], every condition of
/// section 17 that occurred, with its number there.
std::string to_json(const RunResult& run, const FaultLog& faults, const std::string& command,
                    const std::string& arm);

/// What came to emulated boards.
std::string to_json(const BoardEmulator::Counters& counters, const std::string& arm);

}  // namespace veridyn::dvrk
