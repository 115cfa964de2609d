#pragma once

#include "capture_table.hpp"
#include "veridyn/recordings/csv/csv_lines.hpp"

namespace veridyn::internal {

/// Reads the lines before the first row of numbers: a plain header, or the head of an export that a
/// motion-capture program wrote.
/// @throws InvalidInput  "file:line: found ..., expected ...".
CaptureHeader read_capture_header(CsvLines& lines);

}  // namespace veridyn::internal
