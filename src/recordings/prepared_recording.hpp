#pragma once

#include <string>
#include <tuple>
#include <vector>

#include "veridyn/recordings/preprocessing.hpp"

namespace veridyn {

/// A recording as the equations of motion take it under one setting: resampled, filtered and
/// differentiated. All passes after the first visit these segments.
struct PreparedRecording {
  std::vector<Segment> segments;
  PreparationFacts facts;
};

/// Key of a prepared recording: the recording and the reading options, what the arm's model knows
/// of its sensors, and the settings of the preprocessing. What is left out, slow rows and the
/// decimation count later, row by row.
using PreparationKey = std::tuple<std::string, std::vector<double>, std::vector<int>>;
PreparationKey preparation_key(const Model& arm, const std::string& recording,
                               const PreprocessingOptions& options);

/// How many recordings were resampled and filtered since the program began.
long recordings_prepared();

}  // namespace veridyn
