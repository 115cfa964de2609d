#include "diagnosis/watch/step_builder.hpp"

#include <algorithm>
#include <cmath>

namespace veridyn::watching {

void StepBuilder::add(const SmoothedRow& row, double dt, double spacing) {
  rows_.push_back(row);
  if (static_cast<long>(rows_.size()) >= std::max(1L, std::lround(seconds_ / dt))) finish(spacing);
}

void StepBuilder::restart() {
  rows_.clear();
  follows_ = false;
  hypotheses_.reset();
}

void StepBuilder::finish(double spacing) {
  const auto count = static_cast<Eigen::Index>(rows_.size());
  const Eigen::Index n = rows_.front().q.size();
  StepMotion motion{VectorXd(count), MatrixXd(count, n), MatrixXd(count, n), MatrixXd(count, n), spacing};
  MatrixXd tau(count, n);
  for (Eigen::Index k = 0; k < count; ++k) {
    const SmoothedRow& row = rows_[k];
    motion.time[k] = row.time;
    motion.q.row(k) = row.q.transpose();
    motion.dq.row(k) = row.dq.transpose();
    motion.ddq.row(k) = row.ddq.transpose();
    tau.row(k) = row.tau.transpose();
  }
  hypotheses_.evaluate(motion, answer_);
  Step step;
  step.time = motion.time.mean();
  step.torque = tau.colwise().mean().transpose();
  step.position = motion.q.row(count - 1).transpose();
  step.residual = (tau - answer_.torque).colwise().mean().transpose();
  step.rest_friction2 = answer_.rest_friction.colwise().mean().transpose().cwiseAbs2();
  step.parts.resize(n, static_cast<Eigen::Index>(answer_.parts.size()));
  for (size_t p = 0; p < answer_.parts.size(); ++p)
    step.parts.col(p) = answer_.parts[p].colwise().mean().transpose();
  step.columns.resize(n, hypotheses_.size());
  for (int h = 0; h < hypotheses_.size(); ++h)
    step.columns.col(h) = answer_.columns[h].colwise().mean().transpose();
  step.follows = follows_;
  follows_ = true;
  rows_.clear();
  if (on_step) on_step(step);
}

}  // namespace veridyn::watching
