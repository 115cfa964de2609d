#pragma once

#include <vector>

#include "veridyn/math/types.hpp"

namespace veridyn {

/// Delay between a commanded torque and the motors: whole cycles, then a first-order lag. Nothing
/// allocates after the constructor.
class TorquePath {
 public:
  /// @param share  of a change that acts within the cycle, 0 to 1. @param delay  [cycles].
  TorquePath(Eigen::Index joints, double share, int delay)
      : share_(share),
        queue_(static_cast<std::size_t>(delay), VectorXd::Zero(joints)),
        made_(VectorXd::Zero(joints)) {}

  const VectorXd& update(const VectorXd& asked) noexcept {
    if (first_) {  // the motors already hold the arm when the run begins
      for (VectorXd& late : queue_) late = asked;
      made_ = asked;
      first_ = false;
    }
    if (queue_.empty()) {
      made_ += share_ * (asked - made_);
      return made_;
    }
    made_ += share_ * (queue_[next_] - made_);
    queue_[next_] = asked;
    next_ = (next_ + 1) % queue_.size();
    return made_;
  }

 private:
  double share_;
  std::vector<VectorXd> queue_;
  std::size_t next_ = 0;
  VectorXd made_;
  bool first_ = true;
};

}  // namespace veridyn
