#include "veridyn/excitation/prediction.hpp"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>

#include "regressor/stacked_columns.hpp"
#include "support/random.hpp"
#include "excitation/search/base_regressor.hpp"
#include "veridyn/excitation/excitation.hpp"
#include "veridyn/excitation/fourier_trajectory.hpp"
#include "math/numbers.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/identification/base_parameters.hpp"
#include "veridyn/simulation/plausible_model.hpp"

namespace veridyn {
namespace {

constexpr double kRate = 50.0;

MotionSamples some_motion(int joints, unsigned seed) {
  Random random(seed);
  const auto matrix = [&](double size) -> MatrixXd {
    const VectorXd v = random.vector(joints * 4, -size, size);
    return Eigen::Map<const MatrixXd>(v.data(), joints, 4);
  };
  return FourierTrajectory(0.2, matrix(0.8), matrix(0.8), random.vector(joints, -0.3, 0.3))
      .motion(2, kRate);
}

TorqueNoise noise(int joints, double deviation) {
  return {VectorXd::Constant(joints, deviation), 1.0 / kRate, "assumed"};
}

// Weighted least squares on many noisy copies of the torques scatters as predicted.
TEST(Prediction, EqualsTheScatterOfLeastSquares) {
  const Model arm = plausible_model(read_model("planar-2r"), 2).arm;
  const MotionSamples motion = some_motion(2, 3);
  const TorqueNoise assumed = noise(2, 0.05);  // [N m]
  const Prediction p = predict_identification(arm, motion, assumed);
  const BaseRegressor regressor(arm);
  ASSERT_EQ(static_cast<int>(p.parameters.size()), regressor.size());
  MatrixXd W = regressor.stacked(motion);
  VectorXd beta(regressor.size());
  for (int b = 0; b < beta.size(); ++b) beta[b] = p.parameters[b].value;
  const VectorXd tau = W * beta;
  VectorXd sigma(W.rows());
  for (int i = 0; i < 2; ++i) {
    const VectorXd own = tau.segment(i * motion.rows(), motion.rows());
    const double rms = own.norm() / std::sqrt(static_cast<double>(motion.rows()));
    EXPECT_NEAR(p.rms_torque[i], rms, 1e-9 * rms);
    sigma.segment(i * motion.rows(), motion.rows()).setConstant(0.05);
  }
  const MatrixXd weighted = sigma.cwiseInverse().asDiagonal() * W;
  const Eigen::HouseholderQR<MatrixXd> qr(weighted);
  Random random(5);
  const int copies = 400;
  VectorXd square = VectorXd::Zero(beta.size());
  for (int k = 0; k < copies; ++k) {
    // Uniform noise of variance one is as good as any here.
    const VectorXd error =
        random.vector(static_cast<int>(W.rows()), -std::sqrt(3.0), std::sqrt(3.0));
    square += qr.solve(error).cwiseAbs2();
  }
  for (int b = 0; b < beta.size(); ++b) {
    // The scatter of 400 copies is known to 3.5 %; the last row shares an instant with the first.
    const double scatter = std::sqrt(square[b] / copies);
    EXPECT_NEAR(p.parameters[b].deviation / scatter, 1.0, 0.13) << b;
  }
}

// Twice the time, or the same recorded before, halves the variance.
TEST(Prediction, AGivenRecordingOfTheSameMotionHalvesTheVariance) {
  const Model arm = plausible_model(read_model("psm-3dof"), 2).arm;
  const MotionSamples motion = some_motion(3, 3);
  const Prediction alone = predict_identification(arm, motion, noise(3, 0.04));
  const Prediction both = predict_identification(arm, motion, noise(3, 0.04), {motion});
  EXPECT_NEAR(both.mean_relative / alone.mean_relative, std::sqrt(0.5), 1e-9);
  const Prediction louder = predict_identification(arm, motion, noise(3, 0.08));
  EXPECT_NEAR(louder.median_relative / alone.median_relative, 2.0, 1e-9);
}

// The base parameters are combinations of the standard ones: both give the same torques.
TEST(Prediction, BaseParametersGiveTheTorquesOfTheArm) {
  for (const char* name : {"psm-3dof", "psm-wrist", "ur10e"}) {
    const Model arm = read_model(name);
    const BaseRegressor regressor(arm);
    const MotionSamples motion = some_motion(arm.joints(), 1);
    Random random(2);
    const VectorXd phi = random.vector(static_cast<int>(regressor.combination().cols()), -1.0, 1.0);
    const MatrixXd all = regressor.columns()->stacked(motion);
    const VectorXd expected = all * phi;
    const VectorXd got = regressor.stacked(motion) * (regressor.combination() * phi);
    EXPECT_LT((got - expected).norm(), 1e-7 * expected.norm()) << name;
  }
}

// The names that `identify` prints, in its order: one computation of base parameters.
TEST(Prediction, ListsTheSameBaseParametersAsAnIdentification) {
  ExcitationOptions options;
  options.solver = ExcitationSolver::kRandom;
  options.iterations = 1;
  options.starts = 1;
  for (const char* robot : {"planar-2r", "psm-3dof"}) {
    const Model arm = plausible_model(read_model(robot), 2).arm;
    const Excitation e = optimise_excitation(arm, options);
    ASSERT_TRUE(e.prediction.has_value());
    std::vector<std::string> names;
    for (const PredictedParameter& p : e.prediction->parameters) names.push_back(p.name);
    EXPECT_EQ(names, identifiable_base_parameters(arm).names) << robot;
  }
}

// What an identification left is the noise of the next one; without it a share of the largest effort.
TEST(Prediction, TheDefaultNoiseIsThatOfTheModelOrOnePercentOfTheEffort) {
  ModelDescription d = plausible_model(read_model("planar-2r"), 2).arm.description();
  d.coordinates[0].limits.effort = 20.0;
  d.coordinates[1].limits.effort = kInfinity;
  const TorqueNoise assumed = usual_noise(Model(d));
  EXPECT_DOUBLE_EQ(assumed.deviation[0], 0.2);
  EXPECT_GT(assumed.deviation[1], 0.0);
  d.identified.emplace();
  d.identified->noise = Eigen::Vector2d(0.3, 0.04);
  EXPECT_EQ(usual_noise(Model(d)).deviation, d.identified->noise);
}

// Limits of efforts change nothing in what is predicted for a motion.
TEST(Prediction, ExpectedNoiseFollowsTheTorquesOfTheMotion) {
  ModelDescription d = plausible_model(read_model("planar-2r"), 2).arm.description();
  d.coordinates[0].limits.effort = 1e4;
  const MotionSamples motion = some_motion(2, 3);
  const Model arm(d);
  const TorqueNoise expected = expected_noise(arm, motion);
  const Prediction p = predict_identification(arm, motion, expected);
  for (int i = 0; i < 2; ++i)
    EXPECT_NEAR(expected.deviation[i], kUsualResidual * p.rms_torque[i], 1e-9 * p.rms_torque[i]);
  d.identified.emplace();
  d.identified->noise = Eigen::Vector2d(0.3, 0.04);
  EXPECT_EQ(expected_noise(Model(d), motion).deviation, d.identified->noise);
}

TEST(Prediction, RefusesAModelWithoutValues) {
  const Model arm = read_model("psm-3dof");
  EXPECT_THROW(predict_identification(arm, some_motion(3, 1), noise(3, 0.04)), InvalidInput);
  const Model known = plausible_model(arm, 1).arm;
  EXPECT_THROW(predict_identification(known, some_motion(3, 1), noise(2, 0.04)), InvalidInput);
}

}  // namespace
}  // namespace veridyn
