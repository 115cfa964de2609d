#include "period_fold.hpp"
#include "identification/identification_numbers.hpp"

namespace veridyn {
PeriodFold::PeriodFold(int joints, double period)
    : period_(period),
      adjacent_(identifying::numbers.adjacent),
      difference2_(VectorXd::Zero(joints)), torque2_(difference2_) {}

void PeriodFold::add(double time, const MatrixXd& tau, Eigen::Index row) {
  if (period_ <= 0.0) return;
  past_.push_back({time, tau.row(row).transpose()});
  const double then = time - period_;
  while (past_.size() > 1 && past_[1].time <= then) past_.pop_front();
  if (past_.front().time > then || past_.size() < 2) return;
  const Sample& a = past_[0];
  const Sample& b = past_[1];
  if (b.time - a.time > adjacent_) return;
  const double share = (then - a.time) / (b.time - a.time);
  const VectorXd before = a.tau + share * (b.tau - a.tau);
  difference2_ += (past_.back().tau - before).cwiseAbs2();
  torque2_ += 0.5 * (past_.back().tau.cwiseAbs2() + before.cwiseAbs2());
  compared_ = true;
}

VectorXd PeriodFold::relative_floor() const {
  if (!compared_) return {};
  return (0.5 * difference2_.array() / torque2_.array().max(1e-300)).sqrt();
}

}  // namespace veridyn
