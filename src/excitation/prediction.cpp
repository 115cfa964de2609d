#include "veridyn/excitation/prediction.hpp"

#include <Eigen/Cholesky>
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "math/median.hpp"
#include "regressor/random_states.hpp"
#include "regressor/arm_columns.hpp"
#include "regressor/stacked_columns.hpp"
#include "veridyn/regressor/standard_parameters.hpp"
#include "excitation/search/base_regressor.hpp"
#include "model/noise_unit.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr int kStates = 200;
constexpr double kOfRms = 4.0;     // typical ratio of the largest effort to the rms torque
constexpr double kBeyondCount = 1e9;  // relative deviation reported for a zero value

double duration_with_last_step(const MotionSamples& motion) {
  require(motion.rows() >= 2, "prediction: found a motion of ", motion.rows(),
          " rows, expected two or more.");
  return motion.time[motion.rows() - 1] - motion.time[0];
}

VectorXd rms_torque(const Model& arm, const MotionSamples& motion) {
  const StackedColumns all(arm.joints(), arm_columns(arm, 0.0));
  const VectorXd tau = all.stacked(motion) * standard_values(arm);
  const Eigen::Map<const MatrixXd> by_joint(tau.data(), motion.rows(), motion.joints());
  return (by_joint.colwise().squaredNorm() / static_cast<double>(motion.rows()))
      .cwiseSqrt()
      .transpose();
}

// The diagonal of the inverse, computed with scaled columns; infinite if a parameter is not identifiable.
VectorXd variances(const MatrixXd& information) {
  const VectorXd d = information.diagonal().cwiseSqrt().cwiseMax(1e-100).cwiseInverse();
  const Eigen::LLT<MatrixXd> llt(d.asDiagonal() * information * d.asDiagonal());
  if (llt.info() != Eigen::Success)
    return VectorXd::Constant(d.size(), std::numeric_limits<double>::infinity());
  const MatrixXd inverse = llt.solve(MatrixXd::Identity(d.size(), d.size()));
  return inverse.diagonal().cwiseProduct(d.cwiseAbs2());
}

// A joint without torque would have no noise; a small value avoids division by zero.
VectorXd above_zero(const VectorXd& torque) {
  return torque.cwiseMax(1e-6 * std::max(1e-300, torque.maxCoeff()));
}

std::optional<TorqueNoise> identified_noise(const Model& arm) {
  const auto& identified = arm.description().identified;
  if (!identified || identified->noise.size() != arm.joints() || !(identified->noise.minCoeff() > 0.0))
    return std::nullopt;
  TorqueNoise out;
  out.deviation = identified->noise;
  out.seconds = kNoiseSeconds;
  out.source = "what the model's identification left";
  return out;
}

}  // namespace

TorqueNoise noise_of_efforts(const Model& arm, double share) {
  TorqueNoise out;
  out.deviation = VectorXd::Ones(arm.joints());
  if (arm.inertial_values()) out.deviation = rms_torque(arm, random_states(arm, kStates));
  out.deviation = kOfRms * share * above_zero(out.deviation);
  bool limited = false;
  for (int i = 0; i < arm.joints(); ++i) {
    const double effort = arm.coordinates()[i].limits.effort;
    if (!std::isfinite(effort)) continue;
    out.deviation[i] = share * effort;
    limited = true;
  }
  out.source = fmt::format("{:.3g} % of the {}", 100.0 * (limited ? 1.0 : kOfRms) * share,
                           limited ? "largest effort" : "rms torque at random states");
  return out;
}

TorqueNoise usual_noise(const Model& arm) {
  return identified_noise(arm).value_or(noise_of_efforts(arm, kUsualNoise));
}

TorqueNoise expected_noise(const Model& arm, const MotionSamples& motion) {
  if (const std::optional<TorqueNoise> known = identified_noise(arm)) return *known;
  TorqueNoise out;
  out.deviation = kUsualResidual * above_zero(rms_torque(arm, motion));
  out.source = fmt::format("{:.0f} % of the rms torque, as on real arms", 100.0 * kUsualResidual);
  return out;
}

Prediction predict_identification(const Model& arm, const MotionSamples& motion,
                                  const TorqueNoise& noise, const std::vector<MotionSamples>& given,
                                  const std::vector<int>& base) {
  require(noise.deviation.size() == arm.joints() && noise.deviation.minCoeff() > 0.0 &&
              noise.seconds > 0.0,
          "prediction: found noise of ", noise.deviation.size(), " joints, expected ", arm.joints(),
          " positive deviations.");
  const BaseRegressor regressor(arm, base);
  const std::vector<StandardParameter> names = standard_parameters(arm);
  VectorXd unknown = standard_values(arm);  // parameters with known values are not identified
  for (size_t k = 0; k < names.size(); ++k) {
    if (names[k].fixed) unknown[static_cast<Eigen::Index>(k)] = 0.0;
  }
  const VectorXd beta = regressor.combination() * unknown;
  Prediction out;
  out.noise = noise;
  out.values = "of " + arm.name();
  out.rms_torque = rms_torque(arm, motion);
  const VectorXd weights = noise.deviation.cwiseInverse();
  const auto information = [&](const MotionSamples& m) {
    const double independent = duration_with_last_step(m) / noise.seconds / static_cast<double>(m.rows());
    return MatrixXd(independent * regressor.columns()->gram(m, weights));
  };
  MatrixXd sum = information(motion);
  for (const MotionSamples& before : given) sum += information(before);
  const VectorXd deviations = variances(sum).cwiseSqrt();
  std::vector<double> relative;
  for (int b = 0; b < regressor.size(); ++b) {
    const StandardParameter& name = names[regressor.base()[b]];
    const double share = deviations[b] / std::abs(beta[b]);
    out.parameters.push_back({name.name, name.unit, beta[b], deviations[b], share});
    if (share < kBeyondCount) relative.push_back(share);
  }
  if (relative.empty()) relative.push_back(std::numeric_limits<double>::infinity());
  out.mean_relative =
      std::accumulate(relative.begin(), relative.end(), 0.0) / static_cast<double>(relative.size());
  out.median_relative = median(std::move(relative));
  return out;
}

}  // namespace veridyn
