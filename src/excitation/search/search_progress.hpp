#pragma once

#include <chrono>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

namespace veridyn {

/// What several searches have to say, one line now and then. Only messages depend on the clock.
class SearchProgress {
 public:
  using Listener = std::function<void(const std::string&, double)>;

  /// @param steps  of one search, at most.
  SearchProgress(Listener listener, int searches, int steps);

  /// One more step of a search.
  void step(int search, const std::string& news);

  /// A search is over, whatever steps are left.
  void over(int search);

 private:
  void tell(const std::string& news);

  Listener listener_;
  int steps_;
  std::vector<int> done_;
  std::chrono::steady_clock::time_point begun_, told_;
  std::mutex guard_;
};

}  // namespace veridyn
