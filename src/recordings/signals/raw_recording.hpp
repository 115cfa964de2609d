#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace veridyn::recordings {

/// [ns] 95 years on either side of a clock's zero. Times of a RawRecording are within this bound, so that
/// sums and differences of three of them do not overflow; larger times come from damaged data.
inline constexpr std::int64_t kLargestTime = 3000000000000000000;

/// A column of numbers, with its signal and joint if known.
struct RawField {
  std::string path;   ///< path in the file: "elbow_joint/position", "wrench/force/x", "data/0"
  std::string joint;  ///< empty: no signal of a joint
  int signal = -1;    ///< index into kRecordingSignals; -1: none
};

/// Rows of one publisher that all have the same columns.
struct RawStream {
  std::string topic;      ///< empty: the file has only one table
  std::string publisher;  ///< empty: not stored
  std::vector<RawField> fields;
  std::vector<std::int64_t> recorded;  ///< [ns] time at which each row was recorded
  std::vector<std::int64_t> stamped;   ///< [ns] the sender's clock, 0: no stamp; empty: no such clock
  std::vector<double> values;          ///< row by row

  std::size_t rows() const { return recorded.size(); }
  double at(std::size_t row, std::size_t field) const { return values[row * fields.size() + field]; }
};

/// A topic of a container, decoded or not.
struct RawTopic {
  std::string name, type, encoding;
  long messages = 0;
  std::int64_t first = 0;  ///< [ns] time at which the first message was recorded
  std::int64_t last = 0;
  std::string undecoded;  ///< reason if its messages are not decoded; empty: decoded, or not needed
};

/// Contents of a file before the arm's signals are selected.
struct RawRecording {
  std::string format;  ///< "ROS 1 bag", "CSV", ...
  std::vector<RawTopic> topics;
  std::vector<RawStream> streams;
  std::vector<std::string> remarks;
};

}  // namespace veridyn::recordings
