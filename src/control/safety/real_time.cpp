#include "veridyn/control/real_time.hpp"

#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <cstddef>

namespace veridyn {
namespace {

constexpr std::size_t kStack = 256 * 1024;  // [bytes] largest stack use of a cycle

void touch_stack() noexcept {
  volatile unsigned char page[kStack];
  for (std::size_t k = 0; k < kStack; k += 1024) page[k] = 1;
  (void)page[0];
}

}  // namespace

bool set_real_time_priority(int priority) noexcept {
  sched_param wanted{};
  wanted.sched_priority = priority;
  return ::sched_setscheduler(0, SCHED_FIFO, &wanted) == 0;
}

// Only present pages are locked if the amount is limited, so that later allocations do not fail.
bool lock_memory() noexcept {
  touch_stack();
  rlimit limit{};
  const bool unlimited =
      ::getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY;
  return ::mlockall(MCL_CURRENT | MCL_ONFAULT | (unlimited ? MCL_FUTURE : 0)) == 0;
}

}  // namespace veridyn
