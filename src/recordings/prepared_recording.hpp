#pragma once

#include <string>
#include <tuple>
#include <vector>

#include "veridyn/recordings/preprocessing.hpp"

namespace veridyn {

/// A recording prepared for the equations of motion under one setting: resampled, filtered and
/// differentiated. All passes after the first one visit these segments.
struct PreparedRecording {
  std::vector<Segment> segments;
  PreparationFacts facts;
};

/// Key of a prepared recording: the recording and the reading options, the properties of the arm's sensors,
/// and the settings of the preprocessing. Excluded intervals, slow rows and the decimation are applied later,
/// row by row, and are not part of it.
using PreparationKey = std::tuple<std::string, std::vector<double>, std::vector<int>>;
PreparationKey preparation_key(const Model& arm, const std::string& recording,
                               const PreprocessingOptions& options);

/// Number of recordings that were resampled and filtered since the program began.
long recordings_prepared();

}  // namespace veridyn
