#include "excitation/search/search_progress.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <utility>

namespace veridyn {
namespace {

constexpr double kSilence = 0.5;  // [s] shortest time between two lines

}  // namespace

SearchProgress::SearchProgress(Listener listener, int searches, int steps)
    : listener_(std::move(listener)),
      steps_(steps),
      done_(static_cast<size_t>(searches), 0),
      told_(std::chrono::steady_clock::now()) {}

void SearchProgress::step(int search, const std::string& news) {
  if (!listener_) return;
  const std::lock_guard<std::mutex> lock(guard_);
  int& done = done_[search];
  done = std::min(done + 1, steps_);
  const auto now = std::chrono::steady_clock::now();
  if (std::chrono::duration<double>(now - told_).count() < kSilence) return;
  told_ = now;
  const bool several = done_.size() > 1;
  report(several ? fmt::format("start {} of {}: {}", search + 1, done_.size(), news) : news);
}

void SearchProgress::report_ended_search(int search) {
  if (!listener_) return;
  const std::lock_guard<std::mutex> lock(guard_);
  done_[search] = steps_;
}

void SearchProgress::report(const std::string& news) {
  const double all = static_cast<double>(done_.size()) * steps_;
  const double share = std::accumulate(done_.begin(), done_.end(), 0) / all;
  listener_(news, share);
}

}  // namespace veridyn
