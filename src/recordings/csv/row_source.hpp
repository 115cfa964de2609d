#pragma once

#include <memory>
#include <string>

#include "recordings/csv/csv_lines.hpp"
#include "veridyn/recordings/recording.hpp"

namespace veridyn::recordings {

/// Source of a RecordingReader's rows.
class RowSource {
 public:
  virtual ~RowSource() = default;
  virtual Recording next(int rows) = 0;
  virtual int joints() const = 0;
  virtual RecordingFacts facts() const = 0;
};

/// Meaning of decreasing times: an error of the file, or a clock that was set back during the recording.
enum class RowClock { kRises, kMayBeSetBack };

/// Rows of a CSV file with columns t, q1..qn, one after the other.
std::unique_ptr<RowSource> csv_rows(CsvLines lines, const RecordingOptions& options, RowClock clock = RowClock::kRises);

}  // namespace veridyn::recordings
