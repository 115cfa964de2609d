#pragma once

#include <string>
#include <vector>

#include "veridyn/recordings/recording_period.hpp"
#include "veridyn/identification/regressor_columns.hpp"
#include "veridyn/math/square_root_information.hpp"

namespace veridyn {

/// Ranges of one joint's torque, speed and position.
struct TorqueFacts {
  double minimum = 0.0;  ///< smallest filtered torque [N m] or [N]
  double maximum = 0.0;
  double largest_speed = 0.0;  ///< [rad/s] or [m/s]
  double lowest = 0.0;         ///< smallest position [rad] or [m]
  double highest = 0.0;

  double travel() const { return highest - lowest; }  ///< [rad], [m]
};

/// A recording compressed in one pass: a factor for every joint and block of time, without samples.
struct CompressedRecording {
  std::string source;
  PreparationFacts facts;
  /// blocks[k][i]: factor of joint i over the k-th phase of the period (eight, repeats merged). For
  /// a motion that does not repeat, k counts segments of time (8 to 16, for any length).
  std::vector<std::vector<SquareRootInformation>> blocks;
  std::vector<TorqueFacts> joints;
  MotionPeriod period;
  /// (n) relative error of a perfect model, from repeated periods; empty without repeats
  VectorXd noise_floor;
  double rows = 0.0;     ///< number of rows, summed over all joints
  bool detached = false;  ///< only the factor is available, not the samples
};

/// @param path     a recording. It is read twice: its first minutes to find the period, then the whole.
/// @param threads  one thread reads ahead, the others share the joints; 0: one per core. The result does not
///   depend on the number.
CompressedRecording compress(const Model& arm, const std::string& path,
                             const PreprocessingOptions& options, int threads = 1);
CompressedRecording compress(const Model& arm, const Recording& recording,
                             const PreprocessingOptions& options);

/// Compresses all recordings of a list in parallel. @param threads  0: one per core.
std::vector<CompressedRecording> compress_all(const Model& arm,
                                              const std::vector<std::string>& paths,
                                              const PreprocessingOptions& options, int threads);

/// Errors of a model on one recording, per joint.
struct PredictionError {
  VectorXd relative;  ///< ||tau - tau_model|| / ||tau|| over all filtered samples (edges dropped)
  VectorXd maximum;   ///< max|tau - tau_model| / max|tau|
  VectorXd moving_relative;  ///< relative, over samples at which the joint moves (above 2 % of its
                             ///< largest speed)
};

/// A sample at which the joint moves counts in PredictionError::moving_relative.
enum class MovingSample { kNo, kYes };

/// The sums from which PredictionError is computed; they add up over recordings.
struct ErrorSums {
  explicit ErrorSums(int joints);
  void add(const ErrorSums& other);
  /// Adds one sample of joint i. @param moves  the joint counts as moving.
  void add(int i, double measured, double modelled, MovingSample moves);
  PredictionError error() const;

  VectorXd torque2, error2, torque_max, error_max, moving_torque2, moving_error2;
};

/// A decimated series for plots: measured and modelled torque with the motion.
struct PredictionSeries {
  int wanted = 3000;         ///< number of samples: this many to twice as many are kept
  std::vector<double> time;  ///< [s] time since the recording began
  std::vector<std::vector<double>> q, dq, ddq, measured, modelled;  ///< [joint][sample]
};

/// Computes, in a second pass, the errors of given parameter values on every row of a recording, and on request
/// a series of some thousand samples.
///
/// @param without_excluded  if not null, set to the errors outside of the intervals that
/// options.excluded_intervals excludes.
ErrorSums prediction_error(const Model& arm, const std::string& path,
                           const PreprocessingOptions& options, const VectorRef& values,
                           const std::vector<TorqueFacts>& joints,
                           PredictionSeries* series = nullptr,
                           ErrorSums* without_excluded = nullptr, int threads = 1);
ErrorSums prediction_error(const Model& arm, const Recording& recording,
                           const PreprocessingOptions& options, const VectorRef& values,
                           const std::vector<TorqueFacts>& joints,
                           PredictionSeries* series = nullptr,
                           ErrorSums* without_excluded = nullptr);

}  // namespace veridyn
