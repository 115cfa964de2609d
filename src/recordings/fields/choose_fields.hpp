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

/// Location of each signal of each joint.
struct ChosenFields {
  std::vector<std::string> joints;    ///< names of the arm, or of the file if no arm is given
  std::vector<std::string> recorded;  ///< names in the file, joint by joint
  std::vector<std::array<std::optional<FieldPlace>, kSignalCount>> places;  ///< joint by joint
  std::vector<std::string> remarks;
};

/// Selects the columns of the arm.
/// @throws InvalidInput  see assemble().
ChosenFields choose_fields(const RawRecording& raw, const std::string& path,
                           const SignalChoice& choice);

}  // namespace veridyn::recordings
