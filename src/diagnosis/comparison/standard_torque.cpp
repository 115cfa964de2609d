#include "diagnosis/comparison/standard_torque.hpp"

#include <algorithm>
#include <cmath>

#include "kinematics/standard_motion.hpp"
#include "diagnosis/comparison/comparison_numbers.hpp"

namespace veridyn {
namespace {

// The motion as one segment, all of whose samples count.
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

// Weights of the motion's rows (rows x 4) over whole periods of the joint: half the difference and half the sum of
// the means forward and backward, the mean, and the amplitude along the joint's own sine.
MatrixXd row_weights(const MotionSamples& motion, int joint) {
  const Eigen::ArrayXd time = motion.time.array() - motion.time[0];
  const double period = 1.0 / standard_frequency(joint);
  const double whole = period * std::floor(time[time.size() - 1] / period);
  const Eigen::ArrayXd used = (time < whole - comparing::kSameTime).cast<double>();
  const Eigen::ArrayXd forward = used * (motion.dq.col(joint).array() > 0.0).cast<double>();
  const Eigen::ArrayXd backward = used * (motion.dq.col(joint).array() < 0.0).cast<double>();
  const Eigen::ArrayXd there = forward / std::max(forward.sum(), 1.0);
  const Eigen::ArrayXd back = backward / std::max(backward.sum(), 1.0);
  const Eigen::ArrayXd wave = motion.q.col(joint).array() - motion.q(0, joint);
  MatrixXd out(motion.rows(), 4);
  out << 0.5 * (there - back), 0.5 * (there + back), used / used.sum(),
      2.0 / std::max(wave.abs().maxCoeff(), 1e-300) * wave * used / used.sum();
  return out;
}

}  // namespace

StandardTorque::StandardTorque(const Model& arm) : parameters(standard_parameters(arm)) {
  PreprocessingOptions unfiltered;
  unfiltered.cutoff = 0.0;
  unfiltered.decimation = 1;
  const RegressorColumns columns(without_facts(arm), unfiltered);
  const MotionSamples motion = standard_motion(arm);
  joints = columns.rows(segment_of(motion));
  MotionSamples still = motion;
  still.dq.setZero();
  still.ddq.setZero();
  const std::vector<JointRows> resting = columns.rows(segment_of(still));
  const auto all = static_cast<Eigen::Index>(parameters.size());
  rms = weight = MatrixXd::Zero(arm.joints(), all);
  for (int i = 0; i < arm.joints(); ++i) {
    const std::vector<int>& own = joints[i].parameters;
    // M_ii is the torque per unit of acceleration of this joint alone, from rest.
    still.ddq.col(i).setOnes();
    const MatrixXd speeding_up = columns.rows(segment_of(still), {i, i + 1}).front().A;
    still.ddq.col(i).setZero();
    const MatrixXd &moving = joints[i].A, &rest = resting[i].A;
    const MatrixXd W = row_weights(motion, i);
    const VectorXd size = veridyn::rms(moving), least = comparing::numbers.rounded_away * size.cwiseMax(veridyn::rms(speeding_up));
    quantities.push_back(MatrixXd::Zero(all, std::size(kJointQuantities)));
    for (Eigen::Index c = 0; c < size.size(); ++c) {
      const int p = own[c];
      rms(i, p) = size[c];
      weight(i, p) = rest.col(c).cwiseAbs().maxCoeff();
      auto out = quantities.back().row(p);
      if (parameters[p].effect)
        out.head(2) = moving.col(c).transpose() * W.leftCols(2);
      else
        out.segment(2, 2) = rest.col(c).transpose() * W.rightCols(2);
      out[4] = W.col(2).dot(speeding_up.col(c) - rest.col(c));
      for (double& value : out)
        if (std::abs(value) < least[c]) value = 0.0;
    }
  }
}

MatrixXd StandardTorque::torque(int joint, const MatrixRef& values) const {
  return joints[joint].A * values(joints[joint].parameters, Eigen::all);
}

VectorXd rms(const MatrixRef& columns) {
  const auto rows = static_cast<double>(std::max<Eigen::Index>(1, columns.rows()));
  return (columns.colwise().squaredNorm() / rows).cwiseSqrt().transpose();
}

}  // namespace veridyn
