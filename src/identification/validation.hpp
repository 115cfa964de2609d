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

/// One recording with the errors of some parameter values, and the sums behind them.
struct MeasuredRecording {
  RecordingError error;
  MeasuredErrors sums;
  bool detached = false;  ///< Detached of a factor: its samples are elsewhere
};

MeasuredRecording measure(const Model& arm, const CompressedRecording& recording,
                          const PreprocessingOptions& how, const VectorXd& values,
                          int series_samples, int threads);

/// Samples of each series for plots, so that memory does not grow with the recordings.
int series_samples_of_each(int recordings);

/// Held-out recordings, of which only the facts are kept.
/// @throws InvalidInput  one has no usable samples: no error is not an error of 0.
std::vector<CompressedRecording> compress_test(const Model& arm,
                                               const std::vector<std::string>& test,
                                               const PreprocessingOptions& how, int threads);

/// Fills train, test and their errors.
void take_errors(const Model& arm, std::vector<MeasuredRecording> train,
                 std::vector<MeasuredRecording> test, Identification& id);

/// Fills train, test and their errors: those of id.parameters on the recordings of id.factors and
/// on held-out ones.
/// @throws InvalidInput  a held-out recording has no usable samples: no error is not an error of 0.
void validate(const Model& arm, const std::vector<std::string>& test,
              const IdentificationOptions& options, Identification& id);

}  // namespace veridyn
