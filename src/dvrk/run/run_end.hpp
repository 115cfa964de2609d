#pragma once

#include <string>

#include "cycle_clock.hpp"
#include "row_file.hpp"
#include "dvrk/run/arm_run.hpp"

// How runs and recordings end.

namespace veridyn::dvrk {

/// A loop that reached a smaller share of its rate is not what was asked for.
constexpr double kLeastRate = 0.95;

/// Why a loop is stopped that is late all the time.
std::string late_words(const CycleClock& clock);

/// Why a loop that came to its end is not what was asked for; empty if it is.
std::string objection_to(const LoopTiming& timing);

/// Writes the end of the file and its first line, says in `result` what is kept, and sets
/// `complete`.
void finish(RowFile& file, RunResult& result);

}  // namespace veridyn::dvrk
