#pragma once

#include <string>
#include <vector>

#include "veridyn/recordings/recording_period.hpp"
#include "veridyn/identification/regressor_columns.hpp"
#include "veridyn/math/square_root_information.hpp"

namespace veridyn {

/// What one joint's torque was like.
struct TorqueFacts {
  double minimum = 0.0;  ///< [N m] or [N], filtered
  double maximum = 0.0;
  double largest_speed = 0.0;  ///< [rad/s] or [m/s]
  double lowest = 0.0;         ///< position [rad] or [m]
  double highest = 0.0;

  double travel() const { return highest - lowest; }
};

/// A recording after its one pass: a factor for every joint and block of time. No samples.
struct CompressedRecording {
  std::string source;
  PreparationFacts facts;
  /// blocks[k][i]: factor of joint i over the k-th phase of the period (eight, repeats merged) or,
  /// where nothing repeats, over the k-th stretch of time (8 to 16 of them, however long the
  /// recording).
  std::vector<std::vector<SquareRootInformation>> blocks;
  std::vector<TorqueFacts> joints;
  MotionPeriod period;
  VectorXd noise_floor;  ///< (n) relative error of a perfect model, from repeated periods; empty if
                         ///< none repeat
  double rows = 0.0;     ///< over all joints
  bool detached = false;  ///< it came as a factor: its samples are elsewhere
};

/// @param path     a recording; read twice, its first minutes for the period and then all of it.
/// @param threads  one reads ahead, the others share the joints; 0: one per core. The result does
/// not depend on it.
CompressedRecording compress(const Model& arm, const std::string& path,
                             const PreprocessingOptions& options, int threads = 1);
CompressedRecording compress(const Model& arm, const Recording& recording,
                             const PreprocessingOptions& options);

/// Every recording of a list, in parallel. @param threads  0: one per core.
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

/// Whether a joint moves at a sample.
enum class MovingSample { kNo, kYes };

/// Sums behind PredictionError, which add up over recordings.
struct ErrorSums {
  explicit ErrorSums(int joints);
  void add(const ErrorSums& other);
  /// One sample of joint i. @param moves  the joint counts as moving at it.
  void add(int i, double measured, double modelled, MovingSample moves);
  PredictionError error() const;

  VectorXd torque2, error2, torque_max, error_max, moving_torque2, moving_error2;
};

/// One decimated series for plots: measured and modelled torque with the motion.
struct PredictionSeries {
  int wanted = 3000;         ///< samples: so many to twice as many are kept
  std::vector<double> time;  ///< [s] since the recording began
  std::vector<std::vector<double>> q, dq, ddq, measured, modelled;  ///< [joint][sample]
};

/// Second pass: the errors of parameter values on every row of a recording. A series of some
/// thousand samples is kept if asked for.
///
/// @param without_excluded  if not null, becomes the errors without the moments that
///                          options.left_out excludes.
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
