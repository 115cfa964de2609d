#pragma once

#include <string>
#include <vector>

#include "identification/check/questions.hpp"
#include "veridyn/identification/identification.hpp"
#include "veridyn/model/model.hpp"
#include "veridyn/recordings/preprocessing.hpp"
#include "veridyn/recordings/recording.hpp"
#include "veridyn/recordings/recording_quality.hpp"

namespace veridyn {

/// What one recording answers to the questions of check_against().
struct RobotAnswers {
  std::vector<QualityFinding> findings;
  std::vector<RecordingQuestion> set;  ///< questions answered by yes, which explain the recording or most of what it left
  bool explained = false;              ///< the arm explains the recording as it is
};
RobotAnswers answers_of(const Model& arm, const std::string& recording, const PreprocessingOptions& options);

/// Arm and recordings after the questions that they answer by yes; `recordings` holds those that changed.
struct MendedSetUp {
  std::vector<QualityFinding> findings;  ///< one for each mistake
  Model arm;
  RecordingsInMemory recordings;
  bool mended = false;
};

/// Asks all recordings where some error is large. A recording that answers nothing and is not explained either takes the
/// answers of the first one if they explain it.
/// @param fit  an identification from them.
MendedSetUp mended_set_up(const Model& arm, const std::vector<std::string>& recordings, const PreprocessingOptions& options,
                          const Identification& fit);

}  // namespace veridyn
