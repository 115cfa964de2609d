#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <functional>
#include <future>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "veridyn/recordings/preprocessing.hpp"

namespace veridyn::python {

namespace py = pybind11;

/// What long work on a thread of its own shares with the thread that waits for it.
class Progress {
 public:
  /// @param callback  called as callback(what, share); None: nothing is reported.
  explicit Progress(const py::object& callback);

  /// Reports progress, if there is a callback. @throws Interrupted  after Ctrl-C.
  void operator()(const std::string& what, double share) const;

  bool stopped() const { return *stop_; }
  void stop() const { *stop_ = true; }

  /// Rethrows here what the callback raised there. Needs the GIL.
  void rethrow() const;

 private:
  struct Shared;
  std::shared_ptr<std::atomic<bool>> stop_;
  std::shared_ptr<Shared> shared_;  // null without a callback
};

namespace detail {
/// Waits until ready() without the GIL; true if Ctrl-C (or another signal's handler) raised.
bool wait(const std::function<bool(double)>& ready);
}  // namespace detail

/// Runs `work` on a thread of its own without the GIL, and Python's signal handlers meanwhile.
///
/// After Ctrl-C the work is requested to stop; KeyboardInterrupt is raised as soon as it has, or after
/// a second, whichever comes first: the thread then ends by itself. `work` must own what it uses.
template <typename Work>
auto interruptible(const Progress& progress, Work work) -> decltype(work()) {
  std::packaged_task<decltype(work())()> task(std::move(work));
  auto future = task.get_future();
  std::thread worker(std::move(task));
  const auto ready = [&future](double seconds) {
    return future.wait_for(std::chrono::duration<double>(seconds)) == std::future_status::ready;
  };
  if (detail::wait(ready)) {
    progress.stop();
    bool ended = false;
    {
      const py::gil_scoped_release free;
      ended = ready(1.0);
    }
    ended ? worker.join() : worker.detach();
    throw py::error_already_set();
  }
  {
    const py::gil_scoped_release free;
    worker.join();
  }
  progress.rethrow();
  return future.get();
}

}  // namespace veridyn::python
