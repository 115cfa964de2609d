#include "math/parallel.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace veridyn {
namespace {

TEST(ParallelFor, CallsTheBodyOnceForEveryIndex) {
  for (const int threads : {0, 1, 2, 7, 100}) {
    for (const int count : {0, 1, 3, 1000}) {
      std::vector<std::atomic<int>> calls(count);
      parallel_for(count, threads, [&](int i) { ++calls[i]; });
      for (const auto& c : calls) EXPECT_EQ(c, 1) << threads << " threads, count " << count;
    }
  }
}

TEST(ParallelFor, UsesNoMoreThreadsThanAllowed) {
  for (const int threads : {1, 2, 3}) {
    std::set<std::thread::id> seen;
    std::mutex guard;
    parallel_for(64, threads, [&](int) {
      std::this_thread::sleep_for(std::chrono::microseconds(200));
      const std::lock_guard<std::mutex> lock(guard);
      seen.insert(std::this_thread::get_id());
    });
    EXPECT_LE(seen.size(), static_cast<size_t>(threads));
  }
}

// Two bodies that wait for each other finish only if they run at one time.
TEST(ParallelFor, TwoBodiesRunAtTheSameTime) {
  std::atomic<int> here{0};
  std::atomic<bool> met{true};
  parallel_for(2, 2, [&](int) {
    ++here;
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (here < 2 && std::chrono::steady_clock::now() < until) std::this_thread::yield();
    if (here < 2) met = false;
  });
  EXPECT_TRUE(met);
}

TEST(ParallelFor, AnExceptionOfABodyIsRethrownAfterAllHaveFinished) {
  for (const int threads : {1, 4}) {
    std::atomic<int> calls{0};
    const auto body = [&](int i) {
      ++calls;
      if (i == 5) throw std::runtime_error("five");
    };
    try {
      parallel_for(20, threads, body);
      ADD_FAILURE() << "nothing was thrown";
    } catch (const std::runtime_error& e) {
      EXPECT_EQ(std::string(e.what()), "five");
    }
    EXPECT_EQ(calls, 20);
  }
}

}  // namespace
}  // namespace veridyn
