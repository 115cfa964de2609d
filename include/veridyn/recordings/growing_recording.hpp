#pragma once

#include <functional>
#include <memory>
#include <string>

#include "veridyn/recordings/recording.hpp"

namespace veridyn {

/// A recording that is still being written: a CSV file that grows (t, q1..qn, dq1.., tau1..), or
/// standard input.
///
///   GrowingRecording rows("arm.csv", options, [] { return !stopped; });
///   for (Recording row = rows.next(1); row.rows() > 0; row = rows.next(1)) ...
class GrowingRecording {
 public:
  /// Waits for the first line.
  /// @param path  a file, or "-" for standard input.
  /// @param go_on  called about 50 times a second while no data arrive; false ends the recording.
  /// @throws InvalidInput  as RecordingReader.
  GrowingRecording(const std::string& path, const RecordingOptions& options,
                   std::function<bool()> go_on);
  ~GrowingRecording();

  /// Returns the next rows; waits until there are this many, and returns fewer only at the end of the
  /// recording. Times may decrease if the clock was set back.
  /// @throws InvalidInput  as RecordingReader::next().
  Recording next(int rows);

 private:
  std::unique_ptr<recordings::RowSource> source_;
};

}  // namespace veridyn
