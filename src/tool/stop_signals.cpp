#include "veridyn/tool/stop_signals.hpp"

#include <csignal>

namespace veridyn::cli {
namespace {

std::atomic<bool> stop_flag{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set by a signal handler");

extern "C" void request_stop(int) {
  stop_flag.store(true, std::memory_order_relaxed);
}

}  // namespace

const std::atomic<bool>& stop_requested() {
  return stop_flag;
}

void catch_signals() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE}) {
    struct sigaction action {};
    action.sa_handler = request_stop;
    ::sigemptyset(&action.sa_mask);
    ::sigaction(signal, &action, nullptr);
  }
}

}  // namespace veridyn::cli
