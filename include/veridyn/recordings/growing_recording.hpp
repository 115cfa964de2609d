#pragma once

#include <functional>
#include <memory>
#include <string>

#include "veridyn/recordings/recording.hpp"

namespace veridyn {

/// A recording that somebody still writes: a CSV file that grows (t, q1..qn, dq1.., tau1..), or
/// standard input.
///
///   GrowingRecording rows("arm.csv", options, [] { return !stopped; });
///   for (Recording row = rows.next(1); row.rows() > 0; row = rows.next(1)) ...
class GrowingRecording {
 public:
  /// Waits until there is a first line.
  /// @param path  a file, or "-" for standard input.
  /// @param go_on  asked about 50 times a second while nothing comes; false ends the recording.
  /// @throws InvalidInput  as RecordingReader.
  GrowingRecording(const std::string& path, const RecordingOptions& options,
                   std::function<bool()> go_on);
  ~GrowingRecording();

  /// The next rows; waits until there are so many. Fewer only where the recording ended.
  /// @throws InvalidInput  as RecordingReader::next().
  Recording next(int rows);

 private:
  std::unique_ptr<recordings::RowSource> source_;
};

}  // namespace veridyn
