#pragma once

#include <memory>

#include "recordings/csv/row_source.hpp"
#include "veridyn/recordings/signal_choice.hpp"

namespace veridyn::recordings {

/// Rows of a source, in which obvious faults are repaired or become gaps. Each kind of fault gives one remark
/// with the number of rows or of turns:
///
///   equal times  rows with the time of the previous row and other values: spread up to the next time
///   bursts       rows that arrived together: spread evenly since the previous burst
///   wraps        angles that jump by a whole turn: whole turns are added
///   dropouts     positions that jump away and return within a second, torques and velocities that are exactly
///                zero meanwhile, rows of another publisher: positions are interpolated if velocities are
///                recorded, else they become gaps
///
/// With choice.as_recorded only rows that repeat a time are dropped. Memory: the requested rows and those of
/// some seconds.
std::unique_ptr<RowSource> mended(std::unique_ptr<RowSource> rows, const SignalChoice& choice);

}  // namespace veridyn::recordings
