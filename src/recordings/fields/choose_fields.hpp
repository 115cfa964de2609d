#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "recordings/signals/raw_recording.hpp"
#include "veridyn/recordings/signal_choice.hpp"

namespace veridyn::recordings {

/// A column of one of the streams.
struct FieldPlace {
  int stream;
  int field;
};

constexpr int kSignalCount = 5;  ///< equals the size of kRecordingSignals

/// Location of every signal of every joint in a file.
struct ChosenFields {
  std::vector<std::string> joints;    ///< names in the arm, or in the file if no arm is given
  std::vector<std::string> recorded;  ///< name of every joint in the file
  std::vector<std::array<std::optional<FieldPlace>, kSignalCount>> places;  ///< columns of every joint
  std::vector<std::string> remarks;
};

/// Selects the columns of the arm. Columns of a table that are named exactly like its joints become their positions.
/// @throws InvalidInput  see assemble().
ChosenFields choose_fields(RawRecording& raw, const std::string& path, const SignalChoice& choice);

/// The last field that satisfies a condition, of the longest stream that has one.
template <typename Condition>
std::optional<FieldPlace> longest_field(const RawRecording& raw, const Condition& condition) {
  std::optional<FieldPlace> best;
  std::size_t rows = 0;
  for (std::size_t s = 0; s < raw.streams.size(); ++s) {
    const RawStream& stream = raw.streams[s];
    for (std::size_t f = stream.fields.size(); stream.rows() > rows && f-- > 0;) {
      if (!condition(stream, stream.fields[f])) continue;
      best = FieldPlace{static_cast<int>(s), static_cast<int>(f)};
      rows = stream.rows();
    }
  }
  return best;
}

/// The first few names and the number of all, for messages.
std::string first_listed(std::vector<std::string> names);

}  // namespace veridyn::recordings
