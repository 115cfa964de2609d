#pragma once

#include <functional>
#include <string>
#include <vector>

#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// An identification that knows its question and no answer yet.
Identification described(const Model& arm, const IdentificationOptions& options);

/// Root mean square of the recordings' noise floors, relative, (n); empty if none has one.
VectorXd mean_noise_floor(const std::vector<CompressedRecording>& recordings, int joints);

/// Errors of some parameter values on one recording, with its stale rows filled in and as recorded
/// (the same where nothing was filled in).
struct MeasuredErrors {
  ErrorSums prepared, as_recorded;
};

using Predict = std::function<ErrorSums(const PreprocessingOptions&, PredictionSeries*)>;

/// What the values that `predict` stands for are worth on a recording; fills `out`.
MeasuredErrors measure_errors(const CompressedRecording& recording, const PreprocessingOptions& how,
                              const Predict& predict, RecordingError& out);

/// Fills train, test and their errors: those of id.parameters on the recordings of id.factors and
/// on held-out ones.
/// @throws InvalidInput  a held-out recording has no usable samples: no error is not an error of 0.
void validate(const Model& arm, const std::vector<std::string>& test,
              const IdentificationOptions& options, Identification& id);

}  // namespace veridyn
