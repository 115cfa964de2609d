#pragma once

#include <string>

#include "cycle_clock.hpp"
#include "dvrk/run/rows/row_file.hpp"
#include "dvrk/run/arm_run.hpp"

// Checks and files at the end of runs and recordings.

namespace veridyn::dvrk {

/// A loop below this share of its rate counts as incomplete.
constexpr double kLeastRate = 0.95;

/// Reason for which a loop that is late all the time is stopped.
std::string lateness_text(const CycleClock& clock);

/// Reason for which a completed loop is unsatisfactory (below kLeastRate); empty if it is satisfactory.
std::string objection_to(const LoopTiming& timing);

/// Writes the end of the file and its first line; sets `kept`, `file_error` and `complete` of `result`, and
/// `why` if the file failed.
void finish(RowFile& file, RunResult& result);

}  // namespace veridyn::dvrk
