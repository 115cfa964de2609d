#pragma once

#include <string>
#include <vector>

#include "veridyn/math/motion_samples.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// The noise of the torques that a design and a prediction assume. It does not depend on the motion:
/// a larger one says more.
struct TorqueNoise {
  VectorXd deviation;  ///< (n) standard deviation [N m] or [N]
  /// Torques are a sum of what the model says and of errors that stay alike for about so long;
  /// samples closer than that are no further evidence [s].
  double seconds = 0.1;
  std::string source;  ///< Origin of the deviations, in words
};

/// Share of the largest effort, without better knowledge.
constexpr double kUsualNoise = 0.01;

/// A share of each joint's largest effort; where the file gives none, four times that share of its
/// rms torque at random states within the limits (of 1 N m or 1 N where the arm has no values).
TorqueNoise noise_of_efforts(const Model& arm, double share);

/// What the identification of `arm` left of the torques, or else noise_of_efforts(arm, kUsualNoise).
TorqueNoise usual_noise(const Model& arm);

/// How well a recording would tell one base parameter.
struct PredictedParameter {
  std::string name;  ///< Name of its leading standard parameter
  std::string unit;
  double value = 0.0;
  double deviation = 0.0;  ///< standard deviation
  double relative = 0.0;   ///< deviation / |value|
};

struct Prediction {
  TorqueNoise noise;
  VectorXd rms_torque;  ///< (n) along the motion
  std::string values;   ///< whose values these are, in words
  std::vector<PredictedParameter> parameters;
  double mean_relative = 0.0;  ///< Mean of `relative`, without values that are zero
  double median_relative = 0.0;
};

/// What weighted least squares would say about the base parameters after recording a motion, beside
/// what was recorded before.
///
/// @param arm    with values: they give the torques and what a deviation is relative to.
/// @param given  motions recorded before, with the same noise.
/// @param base   which standard parameters lead the base parameters, as in BaseRegressor; none:
/// those
///               that are best conditioned at random states.
/// @throws InvalidInput  a body has no values, or sizes differ.
Prediction predict_identification(const Model& arm, const MotionSamples& motion,
                                  const TorqueNoise& noise,
                                  const std::vector<MotionSamples>& given = {},
                                  const std::vector<int>& base = {});

}  // namespace veridyn
