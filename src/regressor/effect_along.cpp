#include "effect_along.hpp"

#include <algorithm>

namespace veridyn {
namespace {

constexpr Eigen::Index kBlockRows = 512;

MatrixXd columns_of(BoundEffect& effect, const std::vector<AxisSample>& samples) {
  MatrixXd columns(samples.size(), effect.parameter_count());
  EffectColumns row{};
  for (Eigen::Index k = 0; k < columns.rows(); ++k) {
    effect.columns(samples[k], row);
    for (int p = 0; p < effect.parameter_count(); ++p) columns(k, p) = row[p];
  }
  return columns;
}

}  // namespace

MatrixXd rigid_load(const Model& arm, const RegressorBatch& bodies, const MotionView& motion) {
  MatrixXd tau = MatrixXd::Zero(motion.rows(), motion.q.cols());
  const auto phi = arm.inertial_values();
  if (!phi) return tau;
  MatrixXd block;
  for (Eigen::Index first = 0; first < motion.rows(); first += kBlockRows) {
    const Eigen::Index count = std::min(kBlockRows, motion.rows() - first);
    bodies.torques(motion.q.middleRows(first, count), motion.dq.middleRows(first, count),
                   motion.ddq.middleRows(first, count), *phi, block);
    tau.middleRows(first, count) = block;
  }
  return tau;
}

VectorXd effort_along(const Axis& axis, const MatrixXd& tau) {
  return tau * axis.coefficients / axis.coefficients.squaredNorm();
}

std::vector<AxisSample> axis_samples(const BoundEffect& effect, const MotionView& motion,
                                     const MatrixXd& load, double start) {
  const EffectTerm& term = effect.term();
  const Eigen::Index rows = motion.rows();
  std::vector<AxisSample> out(rows);
  for (Eigen::Index k = 0; k < rows; ++k) {
    AxisSample& x = out[k];
    x.time = motion.time[k] - start;
    x.s = term.axis.offset;
    x.from_s = term.from ? term.from->offset : 0.0;
  }
  const auto add = [&](const Axis& axis, const MatrixXd& of, double AxisSample::* sum) {
    for (Eigen::Index i = 0; i < axis.coefficients.size(); ++i) {
      const double c = axis.coefficients[i];
      if (c == 0.0) continue;
      for (Eigen::Index k = 0; k < rows; ++k) out[k].*sum += c * of(k, i);
    }
  };
  add(term.axis, motion.q, &AxisSample::s);
  add(term.axis, motion.dq, &AxisSample::ds);
  add(term.axis, motion.ddq, &AxisSample::dds);
  if (term.from) {
    add(*term.from, motion.q, &AxisSample::from_s);
    add(*term.from, motion.dq, &AxisSample::from_ds);
  }
  if (effect.traits().uses_load && load.rows() == rows) {
    const VectorXd effort = effort_along(term.axis, load);
    for (Eigen::Index k = 0; k < rows; ++k) out[k].load = effort[k];
  }
  return out;
}

MatrixXd columns_along(const BoundEffect& effect, const MotionView& motion, const MatrixXd& load,
                       double start) {
  BoundEffect own = effect;
  own.reset(start);
  return columns_of(own, axis_samples(effect, motion, load, start));
}

MatrixXd ColumnsInPieces::next(const std::vector<AxisSample>& samples) { return columns_of(effect_, samples); }

}  // namespace veridyn
