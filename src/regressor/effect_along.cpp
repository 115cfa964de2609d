#include "effect_along.hpp"

#include <algorithm>

namespace veridyn {
namespace {

constexpr Eigen::Index kBlockRows = 512;

struct RowRange {
  Eigen::Index first, count;
};

// Sets `out` to the samples of the effect's axis in these rows; the load is zero without rows of `load`.
void fill_samples(const BoundEffect& effect, const MotionView& motion, const MatrixXd& load,
                  double start, const RowRange& rows, std::vector<AxisSample>& out) {
  const EffectTerm& term = effect.term();
  AxisSample origin;
  origin.s = term.axis.offset;
  origin.from_s = term.from ? term.from->offset : 0.0;
  out.assign(static_cast<size_t>(rows.count), origin);
  for (Eigen::Index k = 0; k < rows.count; ++k) out[k].time = motion.time[rows.first + k] - start;
  const auto add = [&](const Axis& axis, const MatrixXd& of, double AxisSample::* sum) {
    for (Eigen::Index i = 0; i < axis.coefficients.size(); ++i) {
      const double c = axis.coefficients[i];
      if (c == 0.0) continue;
      const double* values = &of(rows.first, i);
      for (Eigen::Index k = 0; k < rows.count; ++k) out[k].*sum += c * values[k];
    }
  };
  if (rows.count == 0) return;
  add(term.axis, motion.q, &AxisSample::s);
  add(term.axis, motion.dq, &AxisSample::ds);
  add(term.axis, motion.ddq, &AxisSample::dds);
  if (term.from) {
    add(*term.from, motion.q, &AxisSample::from_s);
    add(*term.from, motion.dq, &AxisSample::from_ds);
  }
  if (effect.traits().uses_load && load.rows() == motion.rows()) {
    const VectorXd effort = effort_along(term.axis, load.middleRows(rows.first, rows.count));
    for (Eigen::Index k = 0; k < rows.count; ++k) out[k].load = effort[k];
  }
}

// Computes the columns for samples in order of time, into the rows from `first` on.
void fill_columns(BoundEffect& effect, const std::vector<AxisSample>& samples, Eigen::Index first,
                  MatrixXd& columns) {
  EffectColumns row{};
  for (const AxisSample& sample : samples) {
    effect.columns(sample, row);
    for (int p = 0; p < effect.parameter_count(); ++p) columns(first, p) = row[p];
    ++first;
  }
}

}  // namespace

MatrixXd rigid_load(const Model& arm, const TorqueRegressor& bodies, const MotionView& motion) {
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
  std::vector<AxisSample> out;
  fill_samples(effect, motion, load, start, {0, motion.rows()}, out);
  return out;
}

MatrixXd columns_along(const BoundEffect& effect, const MotionView& motion, const MatrixXd& load,
                       double start) {
  BoundEffect own = effect;
  own.reset(start);
  MatrixXd columns(motion.rows(), own.parameter_count());
  std::vector<AxisSample> samples;
  for (Eigen::Index first = 0; first < motion.rows(); first += kBlockRows) {
    const Eigen::Index count = std::min(kBlockRows, motion.rows() - first);
    fill_samples(effect, motion, load, start, {first, count}, samples);
    fill_columns(own, samples, first, columns);
  }
  return columns;
}

MatrixXd ColumnsInPieces::next(const std::vector<AxisSample>& samples) {
  MatrixXd columns(samples.size(), effect_.parameter_count());
  fill_columns(effect_, samples, 0, columns);
  return columns;
}

}  // namespace veridyn
