#include "math/excerpt.hpp"
#include "cli/options/messages.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>

namespace veridyn::cli {
namespace {

constexpr int kBarWidth = 30;
constexpr double kFirstEstimate = 0.1;  // share of the work before the first estimate
constexpr double kShort = 3.0;          // [s] of work without an estimate
const char* const kClearLine = "\r\033[K";

bool on_terminal() {
  return ::isatty(STDERR_FILENO) != 0;
}

// One progress bar for all of the work, which never goes back and shows the remaining time once
// enough is done.
class Bar {
 public:
  void operator()(const std::string& what, double share) {
    done_ = std::max(done_, std::clamp(share, 0.0, 1.0));
    const int filled = static_cast<int>(kBarWidth * done_);
    const double passed = std::chrono::duration<double>(Clock::now() - begun_).count();
    const std::string left = done_ < kFirstEstimate || passed < kShort
                                 ? ""
                                 : fmt::format(", about {:.0f} s left", passed * (1.0 - done_) / done_);
    const bool colour = std::getenv("NO_COLOR") == nullptr;
    fmt::print(stderr, "{}[{}{:<{}}{}] {:3.0f} % {}{}", kClearLine, colour ? "\033[36m" : "",
               std::string(static_cast<std::size_t>(filled), '#'), kBarWidth, colour ? "\033[0m" : "",
               100.0 * done_, what, left);
    if (share >= 1.0) fmt::print(stderr, "{}", kClearLine);
    std::fflush(stderr);
  }

 private:
  using Clock = std::chrono::steady_clock;
  double done_ = 0.0;
  Clock::time_point begun_ = Clock::now();
};

// Quotes a word that a shell could interpret.
std::string quoted(const std::string& word) {
  const char* const plain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=./,:@%";
  if (!word.empty() && word.find_first_not_of(plain) == std::string::npos) return word;
  std::string out = "'";
  for (const char c : word) {
    if (c == '\'') {
      out += "'\\''";
    } else {
      out += c;
    }
  }
  return out + "'";
}

}  // namespace

std::string command_line(int argc, const char* const* argv) {
  std::string out = "veridyn";  // independent of the path of the program
  for (int k = 1; k < argc; ++k) out += " " + quoted(argv[k]);
  return out;
}

std::string command_line(const std::vector<std::string>& words) {
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : " ") + quoted(word);
  return out;
}

void say(const std::string& line) {
  fmt::print(stderr, "{}veridyn: {}\n", on_terminal() ? kClearLine : "", excerpt(line, line.size()));
}

Progress progress(const CommonOptions& options) {
  if (options.quiet) return {};
  if (on_terminal()) return Bar();
  return [last = std::string()](const std::string& what, double) mutable {
    if (what == last) return;
    last = what;
    say(what);
  };
}

}  // namespace veridyn::cli
