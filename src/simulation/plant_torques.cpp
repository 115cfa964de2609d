#include "plant_torques.hpp"

#include <algorithm>

#include "veridyn/dynamics/regressor_batch.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr Eigen::Index kBlockRows = 512;

// Position, velocity and acceleration at a share u of the way from one row to the next: the quintic
// through all three.
struct Point {
  double q, dq, ddq;
};

Point quintic(const Point& p0, const Point& p1, double h, double u) {
  // In x = u: f = c0 + c1 u + ... + c5 u^5, with derivatives scaled by h.
  const double v0 = h * p0.dq;
  const double v1 = h * p1.dq;
  const double a0 = h * h * p0.ddq;
  const double a1 = h * h * p1.ddq;
  const double rise = p1.q - p0.q - v0 - 0.5 * a0;
  const double slope = v1 - v0 - a0;
  const double bend = a1 - a0;
  const double c3 = 10.0 * rise - 4.0 * slope + 0.5 * bend;
  const double c4 = -15.0 * rise + 7.0 * slope - bend;
  const double c5 = 6.0 * rise - 3.0 * slope + 0.5 * bend;
  return {p0.q + u * (v0 + u * (0.5 * a0 + u * (c3 + u * (c4 + u * c5)))),
          (v0 + u * (a0 + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5)))) / h,
          (a0 + u * (6.0 * c3 + u * (12.0 * c4 + u * 20.0 * c5))) / (h * h)};
}

// The same motion with `substeps` rows for each, so that row k is row k * substeps.
MotionSamples refined(const MotionSamples& m, int substeps) {
  const Eigen::Index rows = (m.rows() - 1) * substeps + 1;
  const Eigen::Index n = m.joints();
  MotionSamples out{VectorXd(rows), MatrixXd(rows, n), MatrixXd(rows, n), MatrixXd(rows, n)};
  for (Eigen::Index row = 0; row < rows; ++row) {
    const Eigen::Index k = std::min(row / substeps, std::max<Eigen::Index>(0, m.rows() - 2));
    const Eigen::Index next = std::min(k + 1, m.rows() - 1);
    const double u = static_cast<double>(row - k * substeps) / substeps;
    const double h = m.time[next] - m.time[k];
    out.time[row] = m.time[k] + u * h;
    for (Eigen::Index i = 0; i < n; ++i) {
      const Point from{m.q(k, i), m.dq(k, i), m.ddq(k, i)};
      const Point to{m.q(next, i), m.dq(next, i), m.ddq(next, i)};
      const Point p = u == 0.0 ? from : u == 1.0 ? to : quintic(from, to, h, u);
      out.q(row, i) = p.q;
      out.dq(row, i) = p.dq;
      out.ddq(row, i) = p.ddq;
    }
  }
  return out;
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
  const Effect& effect = find_effect(term.effect);
  const auto load_of = [&](const MatrixXd& tau) -> VectorXd {
    return effect.needs_load() ? effort_along(term.axis, tau) : VectorXd::Zero(tau.rows());
  };
  if (!effect.has_memory() || substeps == 1)
    return columns_along(arm, term, motion, load_of(rigid));
  const MotionSamples fine = refined(motion, substeps);
  const MatrixXd fine_rigid =
      effect.needs_load() ? rigid_torques(arm, fine) : MatrixXd::Zero(fine.rows(), fine.joints());
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
