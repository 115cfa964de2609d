#pragma once

#include <memory>

#include "recordings/csv/row_source.hpp"
#include "veridyn/recordings/signal_choice.hpp"

namespace veridyn::recordings {

/// Rows of a source in which obvious faults are repaired or become gaps. Each kind of fault has one remark
/// with the number of rows or of turns:
///
///   equal times  rows with other values than the row before and the same time: spread up to the next time
///   bursts       rows that were stamped when many of them arrived at once: spread evenly since the burst before
///   wraps        an angle that goes on at the other end of a turn: whole turns are added
///   dropouts     positions that leave the motion by a jump and come back to it within a second, torques and
///                velocities that are exactly zero meanwhile, rows of another publisher: positions are filled in where
///                velocities are recorded, else gaps
///
/// With choice.as_recorded only rows that repeat a time are left out. Memory: the wanted rows and those of some seconds.
std::unique_ptr<RowSource> mended(std::unique_ptr<RowSource> rows, const SignalChoice& choice);

}  // namespace veridyn::recordings
