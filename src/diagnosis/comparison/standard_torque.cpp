#include "diagnosis/comparison/standard_torque.hpp"

#include <algorithm>
#include <cmath>

#include "kinematics/standard_motion.hpp"
#include "diagnosis/comparison/comparison_numbers.hpp"

namespace veridyn {
namespace {

Segment segment_of(const MotionSamples& motion) {
  Segment s;
  s.dt = motion.time[1] - motion.time[0];
  s.start = motion.time[0];
  s.time = motion.time;
  s.q = motion.q;
  s.dq = motion.dq;
  s.ddq = motion.ddq;
  s.tau = MatrixXd::Zero(motion.rows(), motion.joints());
  s.use.assign(static_cast<size_t>(motion.rows()), 1);
  s.core_end = motion.rows();
  return s;
}

// The arm with all parameters free, so that known ones have columns as well.
Model without_facts(const Model& arm) {
  ModelDescription d = arm.description();
  for (Frame& frame : d.frames) {
    if (frame.body) frame.body->fixed = false;
  }
  for (EffectTerm& term : d.effects) term.fixed = false;
  return Model(std::move(d));
}

VectorXd column(const JointRows& rows, int parameter) {
  const auto at = std::find(rows.parameters.begin(), rows.parameters.end(), parameter);
  if (at == rows.parameters.end()) return VectorXd::Zero(rows.A.rows());
  return rows.A.col(at - rows.parameters.begin());
}

}  // namespace

StandardTorque::StandardTorque(const Model& arm)
    : parameters_(standard_parameters(arm)) {
  PreprocessingOptions unfiltered;
  unfiltered.cutoff = 0.0;
  unfiltered.decimation = 1;
  const Model free = without_facts(arm);
  const RegressorColumns columns(free, unfiltered);
  motion_ = standard_motion(arm);
  MotionSamples motion = motion_;
  moving_ = columns.rows(segment_of(motion));
  motion.dq.setZero();
  motion.ddq.setZero();
  resting_ = columns.rows(segment_of(motion));
  for (Eigen::Index i = 0; i < arm.joints(); ++i) {
    motion.ddq.setZero();
    motion.ddq.col(i).setOnes();
    const auto joint = static_cast<int>(i);
    speeding_up_.push_back(columns.rows(segment_of(motion), {joint, joint + 1}).front());
  }
}

MatrixXd StandardTorque::torque(const VectorRef& values) const {
  MatrixXd out(motion_.rows(), motion_.joints());
  for (Eigen::Index i = 0; i < motion_.joints(); ++i) {
    const JointRows& rows = moving_[i];
    VectorXd own(rows.parameters.size());
    for (size_t p = 0; p < rows.parameters.size(); ++p)
      own[static_cast<Eigen::Index>(p)] = values[rows.parameters[p]];
    out.col(i) = rows.A * own;
  }
  return out;
}

VectorXd StandardTorque::rms_of(int parameter) const {
  VectorXd out(motion_.joints());
  for (Eigen::Index i = 0; i < out.size(); ++i)
    out[i] = rms(column(moving_[i], parameter))[0];
  return out;
}

VectorXd StandardTorque::weight_of(int parameter) const {
  VectorXd out(motion_.joints());
  for (Eigen::Index i = 0; i < out.size(); ++i)
    out[i] = column(resting_[i], parameter).cwiseAbs().maxCoeff();
  return out;
}

VectorXd StandardTorque::column_sizes() const {
  VectorXd out(parameters_.size());
  for (Eigen::Index p = 0; p < out.size(); ++p) out[p] = rms_of(static_cast<int>(p)).norm();
  return out;
}

// Columns of the bodies, or of the effects, times a row of weights.
VectorXd StandardTorque::projected(const JointRows& rows, const VectorXd& on, bool bodies) const {
  VectorXd out = VectorXd::Zero(parameters_.size());
  for (size_t c = 0; c < rows.parameters.size(); ++c) {
    const int p = rows.parameters[c];
    if (parameters_[p].effect.has_value() == bodies) continue;
    out[p] = on.dot(rows.A.col(c));
  }
  return out;
}

VectorXd StandardTorque::quantity(JointQuantity which, int joint) const {
  const auto i = static_cast<size_t>(joint);
  const Eigen::ArrayXd time = motion_.time.array() - motion_.time[0];
  const double period = 1.0 / standard_frequency(joint);
  const double whole = period * std::floor(time[time.size() - 1] / period);
  const Eigen::ArrayXd used = (time < whole - comparing::kSameTime).cast<double>();
  const VectorXd mean = used / used.sum();
  const Eigen::ArrayXd forward = used * (motion_.dq.col(joint).array() > 0.0).cast<double>();
  const Eigen::ArrayXd backward = used * (motion_.dq.col(joint).array() < 0.0).cast<double>();
  const Eigen::ArrayXd there = forward / std::max(forward.sum(), 1.0);
  const Eigen::ArrayXd back = backward / std::max(backward.sum(), 1.0);
  VectorXd out;
  switch (which) {
    case JointQuantity::kFriction:
      out = projected(moving_[i], 0.5 * (there - back), false);
      break;
    case JointQuantity::kOffset:
      out = projected(moving_[i], 0.5 * (there + back), false);
      break;
    case JointQuantity::kWeight:
      out = projected(resting_[i], mean, true);
      break;
    case JointQuantity::kWeightSlope: {
      const Eigen::ArrayXd wave = motion_.q.col(joint).array() - motion_.q(0, joint);
      const double size = std::max(wave.abs().maxCoeff(), 1e-300);
      out = projected(resting_[i], 2.0 / size * wave * mean.array(), true);
      break;
    }
    case JointQuantity::kInertia:
      out = projected(speeding_up_[i], mean, true) - projected(resting_[i], mean, true) +
            projected(speeding_up_[i], mean, false) - projected(resting_[i], mean, false);
      break;
  }
  for (Eigen::Index p = 0; p < out.size(); ++p) {
    const double own = std::max(rms(column(moving_[i], static_cast<int>(p)))[0],
                                rms(column(speeding_up_[i], static_cast<int>(p)))[0]);
    if (std::abs(out[p]) < comparing::numbers.rounded_away * own) out[p] = 0.0;
  }
  return out;
}

VectorXd rms(const MatrixRef& columns) {
  const auto rows = static_cast<double>(std::max<Eigen::Index>(1, columns.rows()));
  return (columns.colwise().squaredNorm() / rows).cwiseSqrt().transpose();
}

}  // namespace veridyn
