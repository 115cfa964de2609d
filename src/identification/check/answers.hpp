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

/// Result of check_against() for one recording, with the transformations that it found.
struct RobotAnswers {
  std::vector<QualityFinding> findings;
  std::vector<RecordingQuestion> set;  ///< transformations that improve the recording
  bool mends = false;                  ///< they explain the recording, or most of its error
  bool explained = false;              ///< the arm explains the recording as it is
  double left = 0.0;                   ///< relative error of the torque as recorded
};
/// Contradictions between a recording and the arm. Delays and gains of torques are not tested: a diagnosis
/// estimates them.
/// @param smallest_error  recordings with a smaller relative error are not tested.
RobotAnswers answers_of(const Model& arm, const std::string& recording, const PreprocessingOptions& options, double smallest_error = 0.0);

/// True if the recording is not explained as it is, and these transformations explain it, or most of its error.
bool would_explain(const std::vector<RecordingQuestion>& set, const Model& arm, const std::string& recording, const PreprocessingOptions& options);

/// True if the recording fits clearly better without these transformations: it does not contain the mistakes.
bool fits_better_without(const std::vector<RecordingQuestion>& set, const Model& arm, const std::string& recording, const PreprocessingOptions& options);

/// If a recording has no torques, computes them from its currents and the drive gains.
void set_torques_from_currents(const Model& arm, Recording& recording);

/// Arm and recordings with the transformations applied; `recordings` holds those that changed.
struct MendedSetUp {
  std::vector<QualityFinding> findings;  ///< one for each mistake
  Model arm;
  RecordingsInMemory recordings;
  bool mended = false;
};

/// Tests all recordings if one has a large error. Training recordings determine the transformations. The
/// first set found is also applied to other recordings, those before it and held-out ones included, that are not
/// explained and that it explains.
/// @param fit  identification from these recordings.
MendedSetUp mended_set_up(const Model& arm, const std::vector<std::string>& train, const std::vector<std::string>& test,
                          const PreprocessingOptions& options, const Identification& fit);

}  // namespace veridyn
