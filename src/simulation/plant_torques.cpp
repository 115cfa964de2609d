#include "plant_torques.hpp"

#include "regressor/effect_along.hpp"
#include "veridyn/effects/channel_effect.hpp"
#include "veridyn/dynamics/torque_regressor.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/simulation/resampled_motion.hpp"

namespace veridyn {
namespace {

// The motion with `substeps` rows per row of m, whose row k becomes row k * substeps.
MotionSamples refined(const MotionSamples& m, int substeps) {
  const Eigen::Index rows = (m.rows() - 1) * substeps + 1;
  VectorXd times(rows);
  for (Eigen::Index row = 0; row < rows; ++row) {
    const Eigen::Index k = row / substeps;
    const double h = k + 1 < m.rows() ? m.time[k + 1] - m.time[k] : 0.0;
    times[row] = m.time[k] + h * static_cast<double>(row - k * substeps) / substeps;
  }
  return motion_at(m, times);
}

}  // namespace

MatrixXd rigid_torques(const Model& arm, const MotionSamples& motion) {
  const auto phi = arm.inertial_values();
  require(phi.has_value(), "simulation: the arm '", arm.name(), "' has bodies without values.");
  return rigid_load(arm, TorqueRegressor(arm), motion);
}

MatrixXd term_columns(const Model& arm, const EffectTerm& term, const MotionSamples& motion,
                        const MatrixXd& rigid, int substeps) {
  const EffectFacts effect(arm, term);
  if (!effect.traits().memory || substeps == 1)
    return columns_along(effect.bound(), motion, rigid, motion.time[0]);
  const MotionSamples fine = refined(motion, substeps);
  const MatrixXd load = effect.traits().uses_load ? rigid_torques(arm, fine) : MatrixXd();
  const MatrixXd all = columns_along(effect.bound(), fine, load, motion.time[0]);
  MatrixXd columns(motion.rows(), all.cols());
  for (Eigen::Index k = 0; k < motion.rows(); ++k) columns.row(k) = all.row(k * substeps);
  return columns;
}

MatrixXd effect_torques(const Model& arm, const MotionSamples& motion, const MatrixXd& load,
                        int substeps, bool (*wanted)(const EffectTerm&)) {
  MatrixXd tau = MatrixXd::Zero(motion.rows(), motion.joints());
  for (const EffectTerm& term : arm.effects()) {
    if (!wanted(term)) continue;
    const EffectFacts effect(arm, term);
    const Eigen::Map<const VectorXd> values(effect.values().data(), effect.parameter_count());
    const VectorXd force = term_columns(arm, term, motion, load, substeps) * values;
    tau += force * term.axis.coefficients.transpose();
  }
  return tau;
}

MatrixXd plant_torques(const Model& arm, const MotionSamples& motion, int substeps) {
  const MatrixXd rigid = rigid_torques(arm, motion);
  MatrixXd tau = rigid + effect_torques(arm, motion, rigid, substeps,
                                        [](const EffectTerm& /*term*/) { return true; });
  if (motion.rows() < 2) return tau;
  const double dt = (motion.time[motion.rows() - 1] - motion.time[0]) / static_cast<double>(motion.rows() - 1);
  const MatrixXd of_arm =
      arm_effect_torques(arm, TorqueRegressor(arm), motion.q, motion.dq, motion.ddq, dt);
  if (of_arm.size() > 0) tau += of_arm;
  return tau;
}

}  // namespace veridyn
