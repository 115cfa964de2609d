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

constexpr int kSignalCount = 5;  ///< as kRecordingSignals

/// Location of every signal of every joint in a file.
struct ChosenFields {
  std::vector<std::string> joints;    ///< names in the arm, or in the file if no arm is given
  std::vector<std::string> recorded;  ///< name of every joint in the file
  std::vector<std::array<std::optional<FieldPlace>, kSignalCount>> places;  ///< of every joint
  std::vector<std::string> remarks;
};

/// Selects the columns of the arm.
/// @throws InvalidInput  see assemble().
ChosenFields choose_fields(const RawRecording& raw, const std::string& path,
                           const SignalChoice& choice);

}  // namespace veridyn::recordings
