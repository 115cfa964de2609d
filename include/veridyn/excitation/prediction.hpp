#pragma once

#include <string>
#include <vector>

#include "veridyn/math/motion_samples.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// Noise of the torques that a design and a prediction assume. It does not depend on the motion, so
/// that larger motions carry more information.
struct TorqueNoise {
  VectorXd deviation;  ///< (n) standard deviation [N m] or [N]
  /// [s] correlation time of the model's errors: samples closer than this count as one.
  double seconds = 0.1;
  std::string source;  ///< source of the deviations, in words
};

/// Share of the largest effort that usual_noise() assumes without an identification.
constexpr double kUsualNoise = 0.01;

/// Noise as a share of each joint's largest effort; if the file has none, four times that share of its rms
/// torque at random states within the limits (of 1 N m or 1 N if the arm has no values).
TorqueNoise noise_of_efforts(const Model& arm, double share);

/// Residual of the identification of `arm`, or else noise_of_efforts(arm, kUsualNoise): the noise
/// for which a motion is designed.
TorqueNoise usual_noise(const Model& arm);

/// Share of a joint's rms torque that a prediction without an identification assumes as noise: the median
/// residual of plain identification on the joints of five real arms (a quarter of them have less than 0.09, a
/// quarter more than 0.34; docs/excitation.md).
constexpr double kUsualResidual = 0.2;

/// Residual of the identification of `arm`, or else kUsualResidual of each joint's rms torque along
/// `motion`: the noise from which the deviations after recording this motion are predicted. Limits
/// of efforts in robot files are often far beyond the torques of any motion.
TorqueNoise expected_noise(const Model& arm, const MotionSamples& motion);

/// Predicted accuracy of one base parameter.
struct PredictedParameter {
  std::string name;  ///< leading standard parameter
  std::string unit;
  double value = 0.0;
  double deviation = 0.0;  ///< standard deviation
  double relative = 0.0;   ///< deviation / |value|
};

struct Prediction {
  TorqueNoise noise;
  VectorXd rms_torque;  ///< (n) rms torque along the motion [N m] or [N]
  std::string values;   ///< source of the parameter values, in words
  std::vector<PredictedParameter> parameters;
  double mean_relative = 0.0;  ///< mean of `relative`, without values that are zero
  double median_relative = 0.0;
};

/// Covariance of the base parameters that weighted least squares would give after recording a motion, in
/// addition to earlier recordings.
///
/// @param arm    an arm with values, for torques and relative deviations.
/// @param given  motions recorded before, with the same noise.
/// @param base   standard parameters that lead the base parameters, as in BaseRegressor; empty:
/// those that are best conditioned at random states.
/// @throws InvalidInput  a body has no values, or sizes differ.
Prediction predict_identification(const Model& arm, const MotionSamples& motion,
                                  const TorqueNoise& noise,
                                  const std::vector<MotionSamples>& given = {},
                                  const std::vector<int>& base = {});

}  // namespace veridyn
