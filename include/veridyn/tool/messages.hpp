#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "veridyn/tool/common_options.hpp"

namespace veridyn::cli {

/// Prints `veridyn: line` on standard error, and clears a progress bar there.
void print_message(const std::string& line);

/// Registers a reason for which a file may be refused later; the error message for this file ends with it.
void explain_refusal(const std::string& file, const std::string& sentence);

/// The error message, with the registered reason for its file.
std::string with_registered_reason(const std::string& refusal);

/// The arguments as one line that a shell parses into the same arguments.
std::string command_line(const std::vector<std::string>& words);

/// A function that is called with the current activity and the share done, 0 to 1.
using Progress = std::function<void(const std::string&, double)>;

/// A progress bar if standard error is a terminal, otherwise a plain line per activity; empty with
/// --quiet.
Progress progress(const CommonOptions& options);

/// Clears a progress bar on a terminal, before lines of the result.
void clear_bar();

/// Shows work whose progress is unknown: while it exists, and after one second, the activity and its seconds
/// on a terminal, one plain line elsewhere; nothing with --quiet. Nothing else may be printed in the
/// meantime.
class Busy {
 public:
  Busy(const CommonOptions& options, std::string what);
  ~Busy();
  Busy(const Busy&) = delete;
  Busy& operator=(const Busy&) = delete;

 private:
  void show();

  std::string what_;
  std::mutex guard_;
  std::condition_variable over_;
  bool done_ = false;
  std::thread shown_;
};

/// The result of `work`, with Busy shown while it runs.
template <class Work>
auto while_busy(const CommonOptions& options, const char* what, Work work) {
  const Busy busy(options, what);
  return work();
}

}  // namespace veridyn::cli
