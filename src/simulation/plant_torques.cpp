#include "plant_torques.hpp"

#include <algorithm>

#include "veridyn/dynamics/regressor_batch.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/simulation/resampled_motion.hpp"

namespace veridyn {
namespace {

constexpr Eigen::Index kBlockRows = 512;

// The same motion with `substeps` rows for each, so that row k is row k * substeps.
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

// Row by row, in order of time.
MatrixXd columns_along(const Model& arm, const EffectTerm& term, const MotionSamples& m,
                       const VectorXd& load) {
  BoundEffect effect(arm, term);
  effect.reset(m.time[0]);
  MatrixXd columns(m.rows(), effect.parameter_count());
  EffectColumns row{};
  for (Eigen::Index k = 0; k < m.rows(); ++k) {
    AxisSample x =
        effect.sample(m.time[k], m.q.data() + k, m.dq.data() + k, m.ddq.data() + k, m.rows());
    x.load = load[k];
    effect.columns(x, row);
    for (int p = 0; p < effect.parameter_count(); ++p) columns(k, p) = row[static_cast<size_t>(p)];
  }
  return columns;
}

}  // namespace

VectorXd effort_along(const Axis& axis, const MatrixXd& tau) {
  return tau * axis.coefficients / axis.coefficients.squaredNorm();
}

MatrixXd rigid_torques(const Model& arm, const MotionSamples& motion) {
  const auto phi = arm.inertial_values();
  require(phi.has_value(), "simulation: the arm '", arm.name(), "' has bodies without values.");
  const RegressorBatch bodies(arm);
  MatrixXd tau(motion.rows(), motion.joints());
  MatrixXd block;
  for (Eigen::Index first = 0; first < motion.rows(); first += kBlockRows) {
    const Eigen::Index count = std::min(kBlockRows, motion.rows() - first);
    bodies.torques(motion.q.middleRows(first, count), motion.dq.middleRows(first, count),
                   motion.ddq.middleRows(first, count), *phi, block);
    tau.middleRows(first, count) = block;
  }
  return tau;
}

MatrixXd effect_columns(const Model& arm, const EffectTerm& term, const MotionSamples& motion,
                        const MatrixXd& rigid, int substeps) {
  const EffectTraits traits = BoundEffect(arm, term).traits();
  const auto load_of = [&](const MatrixXd& tau) -> VectorXd {
    return traits.uses_load ? effort_along(term.axis, tau) : VectorXd::Zero(tau.rows());
  };
  if (!traits.memory || substeps == 1) return columns_along(arm, term, motion, load_of(rigid));
  const MotionSamples fine = refined(motion, substeps);
  const MatrixXd fine_rigid =
      traits.uses_load ? rigid_torques(arm, fine) : MatrixXd::Zero(fine.rows(), fine.joints());
  const MatrixXd all = columns_along(arm, term, fine, load_of(fine_rigid));
  MatrixXd columns(motion.rows(), all.cols());
  for (Eigen::Index k = 0; k < motion.rows(); ++k) columns.row(k) = all.row(k * substeps);
  return columns;
}

MatrixXd effect_torques(const Model& arm, const MotionSamples& motion, const MatrixXd& load,
                        int substeps, bool (*wanted)(const EffectTerm&)) {
  MatrixXd tau = MatrixXd::Zero(motion.rows(), motion.joints());
  for (const EffectTerm& term : arm.effects()) {
    if (!wanted(term)) continue;
    const BoundEffect effect(arm, term);
    const Eigen::Map<const VectorXd> values(effect.values().data(), effect.parameter_count());
    const VectorXd force = effect_columns(arm, term, motion, load, substeps) * values;
    tau += force * term.axis.coefficients.transpose();
  }
  return tau;
}

MatrixXd plant_torques(const Model& arm, const MotionSamples& motion, int substeps) {
  const MatrixXd rigid = rigid_torques(arm, motion);
  return rigid + effect_torques(arm, motion, rigid, substeps,
                                [](const EffectTerm& /*term*/) { return true; });
}

}  // namespace veridyn
