#include "dvrk/run/brake_driver.hpp"

namespace veridyn::dvrk {

double BrakeDriver::current(Wish wish, double now) noexcept {
  if (wish == Wish::kEngaged) {
    phase_ = Phase::kEngaged;
    return brake_.engaged_current;
  }
  if (phase_ == Phase::kEngaged) {
    phase_ = Phase::kPush;
    pushed_at_ = now;
  }
  if (phase_ == Phase::kPush && now - pushed_at_ >= brake_.release_time) phase_ = Phase::kReleased;
  return phase_ == Phase::kPush ? brake_.release_current : brake_.released_current;
}

}  // namespace veridyn::dvrk
