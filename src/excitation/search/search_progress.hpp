#pragma once

#include <chrono>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

namespace veridyn {

/// Merges the progress messages of several searches into occasional lines. Only messages depend on
/// the clock.
class SearchProgress {
 public:
  using Listener = std::function<void(const std::string&, double)>;

  /// @param steps  largest number of steps of one search.
  SearchProgress(Listener listener, int searches, int steps);

  /// Reports one more step of a search.
  void step(int search, const std::string& news);

  /// Reports the end of a search.
  void report_ended_search(int search);

 private:
  void report(const std::string& news);

  Listener listener_;
  int steps_;
  std::vector<int> done_;
  std::chrono::steady_clock::time_point told_;
  std::mutex guard_;
};

}  // namespace veridyn
