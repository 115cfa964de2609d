#pragma once

#include <optional>

#include "recordings/csv/csv_header.hpp"
#include "recordings/signals/raw_recording.hpp"

namespace veridyn::recordings {

/// Reads a text table whose columns have other names than t, q1..qn, as written by PlotJuggler, `rostopic
/// echo -p`, RTDE and MuJoCo, or a header with joint names.
///
/// The time is the column named time, timestamp, stamp, %time, __time or t, or a pair sec and nsec. Its unit
/// follows from its name or, if only one unit is plausible, from its size. Columns of one topic
/// (`/joint_states/elbow/position`) form rows of their own where they are not empty. Degrees and millimetres,
/// named in a column's name or in a second line of units, are converted to SI. Numbers may have a decimal
/// comma if the columns are separated by another character.
/// @throws InvalidInput  rows of different length, text in a column of a joint signal, no time.
RawRecording read_csv_table(CsvLines lines, CsvHeader header, const RecordingOptions& options);

/// The header of a text file for read_csv_table(), or nullopt for a plain recording (t, q1..qn), whose lines are rewound.
std::optional<CsvHeader> table_header(CsvLines& lines, const RecordingOptions& options);

}  // namespace veridyn::recordings
