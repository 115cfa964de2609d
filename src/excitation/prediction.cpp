#include "veridyn/excitation/prediction.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "math/median.hpp"
#include "regressor/arm_columns.hpp"
#include "regressor/stacked_columns.hpp"
#include "veridyn/regressor/standard_parameters.hpp"
#include "excitation/base_regressor.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr double kBeyondCount = 1e9;  // deviations in units of a value that is zero

double lasts(const MotionSamples& motion) {
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

// Diagonal of the inverse, columns scaled first; infinite where a parameter is left open.
VectorXd variances(const MatrixXd& information) {
  const VectorXd d = information.diagonal().cwiseSqrt().cwiseMax(1e-100).cwiseInverse();
  const Eigen::LLT<MatrixXd> llt(d.asDiagonal() * information * d.asDiagonal());
  if (llt.info() != Eigen::Success)
    return VectorXd::Constant(d.size(), std::numeric_limits<double>::infinity());
  const MatrixXd inverse = llt.solve(MatrixXd::Identity(d.size(), d.size()));
  return inverse.diagonal().cwiseProduct(d.cwiseAbs2());
}

}  // namespace

TorqueNoise usual_noise(const Model& arm) {
  const auto& identified = arm.description().identified;
  TorqueNoise out;
  if (identified && identified->error.size() == arm.joints()) {
    out.share = identified->error;
    out.source = "what the model's identification left";
  } else {
    out.share = VectorXd::Constant(arm.joints(), kUsualNoise);
    out.source = "assumed";
  }
  return out;
}

Prediction predict_identification(const Model& arm, const MotionSamples& motion,
                                  const TorqueNoise& noise, const std::vector<MotionSamples>& given,
                                  const std::vector<int>& base) {
  require(noise.share.size() == arm.joints() && noise.share.minCoeff() > 0.0 && noise.seconds > 0.0,
          "prediction: found noise of ", noise.share.size(), " joints, expected ", arm.joints(),
          " positive shares.");
  const BaseRegressor regressor(arm, base);
  const std::vector<StandardParameter> names = standard_parameters(arm);
  VectorXd unknown = standard_values(arm);  // facts are no part of what is identified
  for (size_t k = 0; k < names.size(); ++k) {
    if (names[k].fixed) unknown[static_cast<Eigen::Index>(k)] = 0.0;
  }
  const VectorXd beta = regressor.combination() * unknown;
  Prediction out;
  out.noise = noise;
  out.values = "of " + arm.name();
  out.rms_torque = rms_torque(arm, motion);
  // A joint without any torque has no noise in this picture: a little, so that nothing divides by
  // zero.
  const double floor = 1e-6 * std::max(1e-300, out.rms_torque.maxCoeff());
  const VectorXd weights = out.rms_torque.cwiseMax(floor).cwiseProduct(noise.share).cwiseInverse();
  const auto information = [&](const MotionSamples& m) {
    const double independent = lasts(m) / noise.seconds / static_cast<double>(m.rows());
    return MatrixXd(independent * regressor.columns()->gram(m, weights));
  };
  MatrixXd sum = information(motion);
  for (const MotionSamples& before : given) sum += information(before);
  const VectorXd deviations = variances(sum).cwiseSqrt();
  std::vector<double> relative;
  for (int b = 0; b < regressor.size(); ++b) {
    const StandardParameter& name = names[static_cast<size_t>(regressor.base()[static_cast<size_t>(b)])];
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
