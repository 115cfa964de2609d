#pragma once

#include <string>
#include <vector>

#include "veridyn/math/motion_samples.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// The noise of the torques that a prediction assumes.
struct TorqueNoise {
  /// (n) standard deviation as a share of each joint's rms torque along the motion.
  VectorXd share;
  /// Torques are a sum of what the model says and of errors that stay alike for about so long;
  /// samples closer than that are no further evidence [s].
  double seconds = 0.1;
  std::string source;  ///< Origin of the share, in words
};

/// Without better knowledge.
constexpr double kUsualNoise = 0.04;

/// The relative errors that the identification of `arm` left, or else kUsualNoise on all joints.
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
