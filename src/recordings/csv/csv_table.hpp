#pragma once

#include "recordings/csv/csv_lines.hpp"
#include "recordings/signals/raw_recording.hpp"
#include "veridyn/recordings/recording.hpp"

namespace veridyn::recordings {

/// A table of text whose columns have other names than t, q1..qn: what PlotJuggler, `rostopic echo
/// -p`, RTDE and MuJoCo write, or a header with joints' names.
///
/// The time is the column named time, timestamp, stamp, %time, __time or t, or a pair sec and nsec;
/// its unit is the one behind its name, or follows from its size where only one makes sense.
/// Columns of one topic (`/joint_states/elbow/position`) are rows of their own where they are not
/// empty. Degrees and millimetres in a column's name, or in a second line of units, are turned into
/// SI. Numbers with a decimal comma are read where another sign separates the columns.
/// @throws InvalidInput  ragged rows, text in a column that is a joint's signal, no time.
RawRecording read_csv_table(CsvLines lines, const RecordingOptions& options);

/// Whether the first line of a text file is a header that read_csv_table() understands and that is
/// not that of a plain recording (t, q1..qn). The lines are at the first one again afterwards.
bool is_csv_table(CsvLines& lines, const RecordingOptions& options);

}  // namespace veridyn::recordings
