#include "nodes/motor_link.hpp"

#include <sys/resource.h>
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace veridyn_ros {
namespace {

constexpr double kShortest = 1e-6;  // [s] lower end of the histogram
constexpr double kStep = 1.05;

// [s] processor time of the whole process.
double processor_seconds() {
  rusage used{};
  ::getrusage(RUSAGE_SELF, &used);
  const auto seconds = [](const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); };
  return seconds(used.ru_utime) + seconds(used.ru_stime);
}

}  // namespace

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

void TimeHistogram::add_time(double seconds) noexcept {
  const double x = std::max(seconds, kShortest);  // NaN becomes the shortest as well
  const double place = std::log(x / kShortest) / std::log(kStep);
  ++counts_[static_cast<std::size_t>(std::min(place, static_cast<double>(counts_.size() - 1)))];
  ++all_;
  worst_ = std::max(worst_, seconds);
}

double TimeHistogram::quantile(double share) const noexcept {
  std::uint64_t below = 0;
  for (std::size_t k = 0; k < counts_.size(); ++k) {
    below += counts_[k];
    if (below > 0 && static_cast<double>(below) >= share * static_cast<double>(all_))
      return std::min(worst_, kShortest * std::pow(kStep, static_cast<double>(k + 1)));
  }
  return 0.0;
}

std::string histogram_text(const TimeHistogram& spread) {
  char out[120];
  std::snprintf(out, sizeof out, "median %.3f, 99.9 %% %.3f, worst %.3f ms", 1e3 * spread.quantile(0.5),
                1e3 * spread.quantile(0.999), 1e3 * spread.worst());
  return out;
}

std::string LoopFigures::timing_text(double seconds) const {
  char out[400];
  std::snprintf(out, sizeof out, "%.0f cycles of %.4f ms; late by %s; computing %s; %.0f more than half a period late; processor %.0f %% of a core",
                cycles, 1e3 * mean_period, histogram_text(late).c_str(), histogram_text(compute).c_str(), overruns,
                100.0 * processor_seconds() / std::max(seconds, 1e-3));
  return out;
}

}  // namespace veridyn_ros
