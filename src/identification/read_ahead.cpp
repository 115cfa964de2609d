#include "read_ahead.hpp"

#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

namespace veridyn {
namespace {

constexpr size_t kAhead = 2;  // segments

struct NobodyReads {};  // thrown in the reading thread after the visitor has failed

class Queue {
 public:
  void put(const Stretch& stretch) {
    std::unique_lock<std::mutex> lock(guard_);
    changed_.wait(lock, [this] { return closed_ || stretches_.size() < kAhead; });
    if (closed_) throw NobodyReads();
    stretches_.push_back(stretch);
    changed_.notify_all();
  }

  // False at the end of the recording.
  bool take(Stretch& out) {
    std::unique_lock<std::mutex> lock(guard_);
    changed_.wait(lock, [this] { return ended_ || !stretches_.empty(); });
    if (stretches_.empty()) return false;
    out = std::move(stretches_.front());
    stretches_.pop_front();
    changed_.notify_all();
    return true;
  }

  void end() {
    const std::lock_guard<std::mutex> lock(guard_);
    ended_ = true;
    changed_.notify_all();
  }

  void close() {
    const std::lock_guard<std::mutex> lock(guard_);
    closed_ = true;
    changed_.notify_all();
  }

 private:
  std::mutex guard_;
  std::condition_variable changed_;
  std::deque<Stretch> stretches_;
  bool ended_ = false;
  bool closed_ = false;
};

}  // namespace

PreparationFacts read_ahead(const StretchPass& pass, const VisitStretch& visit) {
  Queue queue;
  PreparationFacts facts;
  std::exception_ptr failed;
  std::thread reader([&] {
    try {
      facts = pass([&queue](const Stretch& s) { queue.put(s); });
    } catch (const NobodyReads&) {
      // The visitor's own exception has the reason.
    } catch (...) {
      failed = std::current_exception();
    }
    queue.end();
  });
  std::exception_ptr of_visitor;
  try {
    Stretch stretch;
    while (queue.take(stretch)) visit(stretch);
  } catch (...) {
    of_visitor = std::current_exception();
    queue.close();
  }
  reader.join();
  if (of_visitor) std::rethrow_exception(of_visitor);
  if (failed) std::rethrow_exception(failed);
  return facts;
}

}  // namespace veridyn
