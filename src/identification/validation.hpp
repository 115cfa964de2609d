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

/// Errors of some parameter values on one recording: on every row as recorded, with the rows of a
/// late publisher filled in, and of these without what is left out. Equal where there is nothing to
/// fill in or to leave out.
struct MeasuredErrors {
  ErrorSums as_recorded, repaired, without_excluded;
};

/// Errors on every row; the last argument, if not null, becomes those without what is left out.
using Predict =
    std::function<ErrorSums(const PreprocessingOptions&, PredictionSeries*, ErrorSums*)>;

/// What the values that `predict` stands for are worth on a recording; fills `out`.
MeasuredErrors measure_errors(const CompressedRecording& recording, const PreprocessingOptions& how,
                              const Predict& predict, RecordingError& out);

/// Fills train, test and their errors: those of id.parameters on the recordings of id.factors and
/// on held-out ones.
/// @throws InvalidInput  a held-out recording has no usable samples: no error is not an error of 0.
void validate(const Model& arm, const std::vector<std::string>& test,
              const IdentificationOptions& options, Identification& id);

}  // namespace veridyn
