#pragma once

#include <functional>
#include <string>
#include <vector>

#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// A result with the settings filled in and no values yet.
Identification empty_identification(const Model& arm, const IdentificationOptions& options);

/// Root mean square of the recordings' noise floors, relative, (n); empty if none has one.
VectorXd mean_noise_floor(const std::vector<CompressedRecording>& recordings, int joints);

/// Why a recording without usable samples has none, with the options that cut its ends.
std::string no_sample_left(const CompressedRecording& recording, const PreprocessingOptions& how);

/// True if the torques of all joints are zero throughout, or smaller than any sensor shows.
bool without_torque(const CompressedRecording& recording);

/// Errors of given parameter values on one recording: on every row as recorded; with interpolated
/// rows of a late publisher; and of these outside excluded intervals. Equal if there are no such
/// rows.
struct MeasuredErrors {
  ErrorSums as_recorded, repaired, without_excluded;
};

/// Computes errors on every row; the last argument, if not null, is set to those outside excluded
/// intervals.
using Predict =
    std::function<ErrorSums(const PreprocessingOptions&, PredictionSeries*, ErrorSums*)>;

/// Errors of the values behind `predict` on a recording; fills `out`.
MeasuredErrors measure_errors(const CompressedRecording& recording, const PreprocessingOptions& how,
                              const Predict& predict, RecordingError& out);

/// One recording with the errors of given parameter values, and their sums.
struct MeasuredRecording {
  RecordingError error;
  MeasuredErrors sums;
  bool detached = false;  ///< known by its factor only; its samples are elsewhere
};

MeasuredRecording measure(const Model& arm, const CompressedRecording& recording,
                          const PreprocessingOptions& how, const VectorXd& values,
                          int series_samples, int threads);

/// Number of samples of each series for plots, which bounds the memory for many recordings.
int series_samples_of_each(int recordings);

/// Compresses held-out recordings, of which only the facts are kept.
/// @throws InvalidInput  one has no usable samples, which must not count as an error of 0.
std::vector<CompressedRecording> compress_test(const Model& arm,
                                               const std::vector<std::string>& test,
                                               const PreprocessingOptions& how, int threads);

/// Fills train, test and their errors.
void set_errors(const Model& arm, std::vector<MeasuredRecording> train,
                 std::vector<MeasuredRecording> test, Identification& id);

/// Fills train, test and their errors for id.parameters, on the recordings of id.factors and on
/// held-out ones.
/// @throws InvalidInput  a held-out recording has no usable samples, which must not count as an
/// error of 0.
void validate(const Model& arm, const std::vector<std::string>& test,
              const IdentificationOptions& options, Identification& id);

}  // namespace veridyn
