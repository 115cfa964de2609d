#include "math/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <new>
#include <system_error>
#include <thread>
#include <vector>

namespace veridyn {

int number_of_threads(int threads) {
  return threads > 0 ? threads
                     : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

int threads_of_each(int count, int threads) {
  return std::max(1, number_of_threads(threads) / std::max(1, count));
}

void parallel_for(int count, int threads, const std::function<void(int)>& body) {
  const int workers = std::min(count, number_of_threads(threads));
  std::atomic<int> next{0};
  std::exception_ptr first;
  std::mutex guard;
  const auto work = [&] {
    for (int i = next++; i < count; i = next++) {
      try {
        body(i);
      } catch (...) {
        const std::lock_guard<std::mutex> lock(guard);
        if (!first) first = std::current_exception();
      }
    }
  };
  std::vector<std::thread> pool;
  pool.reserve(std::max(0, workers));
  try {
    for (int w = 1; w < workers; ++w) pool.emplace_back(work);
  } catch (const std::system_error&) {
    // Fewer threads than wanted give the same result.
  } catch (const std::bad_alloc&) {
  }
  work();
  for (std::thread& t : pool) t.join();
  if (first) std::rethrow_exception(first);
}

}  // namespace veridyn
