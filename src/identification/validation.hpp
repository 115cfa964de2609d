#pragma once

#include <functional>
#include <string>
#include <vector>

#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// A result with the settings filled in and no values yet.
Identification empty_identification(const Model& arm, const IdentificationOptions& options);

/// Relative noise floors (n): root mean square over the recordings; empty if none has one.
VectorXd mean_noise_floor(const std::vector<CompressedRecording>& recordings, int joints);

/// Reason for which a recording has no usable sample, with the options that cut its ends.
std::string no_sample_left(const CompressedRecording& recording, const PreprocessingOptions& how);

/// True if the torques of all joints are zero, or smaller than the resolution of any sensor, in all rows.
bool without_torque(const CompressedRecording& recording);

/// Errors of given parameters on one recording: on every row as recorded; with interpolated rows of a late
/// publisher; and of the latter those outside of excluded intervals. All three are equal if no such rows
/// exist.
struct MeasuredErrors {
  ErrorSums as_recorded, repaired, without_excluded;
};

/// Computes errors on every row; the last argument, unless null, is set to the errors outside of excluded
/// intervals.
using Predict =
    std::function<ErrorSums(const PreprocessingOptions&, PredictionSeries*, ErrorSums*)>;

/// Errors of the parameters that `predict` uses on a recording; fills `out`.
MeasuredErrors measure_errors(const CompressedRecording& recording, const PreprocessingOptions& how,
                              const Predict& predict, RecordingError& out);

/// One recording with the errors of given parameters, and their sums.
struct MeasuredRecording {
  RecordingError error;
  MeasuredErrors sums;
  bool detached = false;  ///< only its factor is available, not its samples
};

MeasuredRecording measure(const Model& arm, const CompressedRecording& recording,
                          const PreprocessingOptions& how, const VectorXd& values,
                          int series_samples, int threads);

/// Number of samples of each series for plots, chosen to bound the memory of many recordings.
int series_samples_of_each(int recordings);

/// Compresses held-out recordings and keeps only the facts about them.
/// @throws InvalidInput  one has no usable samples; its error must not count as 0.
std::vector<CompressedRecording> compress_test(const Model& arm,
                                               const std::vector<std::string>& test,
                                               const PreprocessingOptions& how, int threads);

/// Fills train, test and their errors.
void set_errors(const Model& arm, std::vector<MeasuredRecording> train,
                 std::vector<MeasuredRecording> test, Identification& id);

/// Fills train, test and their errors for id.parameters, on the recordings of id.factors and on held-out
/// ones.
/// @throws InvalidInput  a held-out recording has no usable samples; its error must not count as 0.
void validate(const Model& arm, const std::vector<std::string>& test,
              const IdentificationOptions& options, Identification& id);

}  // namespace veridyn
