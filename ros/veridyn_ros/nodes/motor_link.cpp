#include "nodes/motor_link.hpp"

#include <time.h>

#include <cmath>

namespace veridyn_ros {

double steady_now() noexcept {
  timespec t{};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

Cycle::Cycle(double period) : period_(period), next_(steady_now() + period), last_(steady_now()) {}

double Cycle::wait() noexcept {
  timespec t{};
  t.tv_sec = static_cast<time_t>(next_);
  t.tv_nsec = static_cast<long>((next_ - std::floor(next_)) * 1e9);
  while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) != 0) {
  }
  const double now = steady_now();
  latest_ = now - next_;
  next_ += period_;
  if (next_ < now) next_ = now + period_;
  const double dt = now - last_;
  last_ = now;
  return dt;
}

}  // namespace veridyn_ros
