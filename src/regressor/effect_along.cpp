#include "effect_along.hpp"

#include <algorithm>

namespace veridyn {
namespace {

constexpr Eigen::Index kBlockRows = 512;

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
  BoundEffect own = effect;
  own.reset(start);
  const Eigen::Index rows = motion.rows();
  const bool loaded = effect.traits().uses_load && load.rows() == rows;
  const VectorXd effort = loaded ? effort_along(effect.term().axis, load) : VectorXd::Zero(rows);
  std::vector<AxisSample> out;
  out.reserve(static_cast<size_t>(rows));
  for (Eigen::Index k = 0; k < rows; ++k) {
    out.push_back(own.sample(motion.time[k], motion.q.data() + k, motion.dq.data() + k,
                             motion.ddq.data() + k, rows));
    out.back().load = effort[k];
  }
  return out;
}

MatrixXd columns_along(const BoundEffect& effect, const MotionView& motion, const MatrixXd& load,
                       double start) {
  BoundEffect own = effect;
  own.reset(start);
  MatrixXd columns(motion.rows(), effect.parameter_count());
  Eigen::Index k = 0;
  EffectColumns row{};
  for (const AxisSample& x : axis_samples(effect, motion, load, start)) {
    own.columns(x, row);
    for (int p = 0; p < effect.parameter_count(); ++p) columns(k, p) = row[static_cast<size_t>(p)];
    ++k;
  }
  return columns;
}

}  // namespace veridyn
