#include "veridyn/dvrk/real_time.hpp"

#include <sched.h>

namespace veridyn::dvrk {

bool take_real_time_priority(int priority) noexcept {
  sched_param wanted{};
  wanted.sched_priority = priority;
  return ::sched_setscheduler(0, SCHED_FIFO, &wanted) == 0;
}

}  // namespace veridyn::dvrk
