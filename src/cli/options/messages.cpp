#include "cli/options/messages.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace veridyn::cli {
namespace {

constexpr int kBarWidth = 30;
const char* const kClearLine = "\r\033[K";

bool on_terminal() {
  return ::isatty(STDERR_FILENO) != 0;
}

void draw_bar(const std::string& what, double share) {
  const int filled = static_cast<int>(kBarWidth * std::clamp(share, 0.0, 1.0));
  fmt::print(stderr, "{}[{:<{}}] {:3.0f} % {}", kClearLine, std::string(filled, '#'), kBarWidth,
             100.0 * share, what);
  if (share >= 1.0) fmt::print(stderr, "{}", kClearLine);
  std::fflush(stderr);
}

// Anything that a shell could read differently goes between quotes.
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
  std::string out = "veridyn";  // wherever it was started from
  for (int k = 1; k < argc; ++k) out += " " + quoted(argv[k]);
  return out;
}

std::string command_line(const std::vector<std::string>& words) {
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : " ") + quoted(word);
  return out;
}

void say(const std::string& line) {
  fmt::print(stderr, "{}veridyn: {}\n", on_terminal() ? kClearLine : "", line);
}

Progress progress(const CommonOptions& options) {
  if (options.quiet) return {};
  if (on_terminal()) return draw_bar;
  return [last = std::string()](const std::string& what, double) mutable {
    if (what == last) return;
    last = what;
    say(what);
  };
}

}  // namespace veridyn::cli
