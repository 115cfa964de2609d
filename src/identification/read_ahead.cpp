#include "read_ahead.hpp"

#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

namespace veridyn {
namespace {

constexpr size_t kAhead = 2;  // largest number of segments that are read ahead

struct ReaderStopped {};  // thrown in the reading thread after the visitor has failed

class Queue {
 public:
  // Stores a segment once there is space. Throws ReaderStopped after close().
  void put(const Segment& segment) {
    std::unique_lock<std::mutex> lock(guard_);
    changed_.wait(lock, [this] { return closed_ || segments_.size() < kAhead; });
    if (closed_) throw ReaderStopped();
    segments_.push_back(segment);
    changed_.notify_all();
  }

  // False at the end of the recording.
  bool pop(Segment& out) {
    std::unique_lock<std::mutex> lock(guard_);
    changed_.wait(lock, [this] { return ended_ || !segments_.empty(); });
    if (segments_.empty()) return false;
    out = std::move(segments_.front());
    segments_.pop_front();
    changed_.notify_all();
    return true;
  }

  // Tells the reader that no segment follows.
  void end() {
    const std::lock_guard<std::mutex> lock(guard_);
    ended_ = true;
    changed_.notify_all();
  }

  // Stops the writer at its next segment.
  void close() {
    const std::lock_guard<std::mutex> lock(guard_);
    closed_ = true;
    changed_.notify_all();
  }

 private:
  std::mutex guard_;
  std::condition_variable changed_;
  std::deque<Segment> segments_;
  bool ended_ = false;
  bool closed_ = false;
};

}  // namespace

PreparationFacts read_ahead(const StretchPass& pass, const VisitSegment& visit) {
  Queue queue;
  PreparationFacts facts;
  std::exception_ptr failed;
  std::thread reader;
  const auto read = [&] {
    try {
      facts = pass([&queue](const Segment& s) { queue.put(s); });
    } catch (const ReaderStopped&) {
      // The exception of the visitor is rethrown instead, since it has the reason.
    } catch (...) {
      failed = std::current_exception();
    }
    queue.end();
  };
  try {
    reader = std::thread(read);
  } catch (const std::system_error&) {
    return pass(visit);  // no memory for another thread: reads and visits in turn
  }
  std::exception_ptr of_visitor;
  try {
    Segment segment;
    while (queue.pop(segment)) visit(segment);
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
