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
  double left = 0.0;                   ///< relative error of the torque as recorded
};
/// @param ask_above  of a recording that leaves no more than this nothing is asked.
RobotAnswers answers_of(const Model& arm, const std::string& recording, const PreprocessingOptions& options, double ask_above = 0.0);

/// True if these questions explain the recording, or most of what it leaves.
bool would_mend(const std::vector<RecordingQuestion>& set, const Model& arm, const std::string& recording, const PreprocessingOptions& options);

/// Currents times the gains of their drives, where a recording has no torques.
void give_torques(const Model& arm, Recording& recording);

/// Arm and recordings after the questions that they answer by yes; `recordings` holds those that changed.
struct MendedSetUp {
  std::vector<QualityFinding> findings;  ///< one for each mistake
  Model arm;
  RecordingsInMemory recordings;
  bool mended = false;
};

/// Asks all recordings where some error is large. Training recordings choose the transformations: one that answers
/// nothing and is not explained either takes those of the first one if they explain it, and so does a held-out one.
/// @param fit  an identification from them.
MendedSetUp mended_set_up(const Model& arm, const std::vector<std::string>& train, const std::vector<std::string>& test,
                          const PreprocessingOptions& options, const Identification& fit);

}  // namespace veridyn
