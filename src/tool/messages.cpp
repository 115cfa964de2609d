#include "model/excerpt.hpp"
#include "veridyn/tool/messages.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <optional>
#include <utility>

namespace veridyn::cli {
namespace {

constexpr int kBarWidth = 30;
constexpr double kFirstEstimate = 0.1;  // share of the work that must be done before the first estimate
constexpr double kShort = 3.0;          // [s] work before the first estimate
constexpr double kRedraw = 0.05;        // [s] between two drawings of a bar
constexpr double kQuietFor = 2.0;       // [s] between two plain lines of one stage
constexpr std::size_t kLongest = 100;   // largest number of characters of an activity beside a bar, in one line
const char* const kClearLine = "\r\033[K";

bool on_terminal() {
  return ::isatty(STDERR_FILENO) != 0;
}

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

// If standard error is full or closed, the message is lost, but the work continues.
template <typename... Parts>
void to_standard_error(fmt::format_string<Parts...> format, Parts&&... parts) {
  std::fputs(fmt::format(format, std::forward<Parts>(parts)...).c_str(), stderr);
}

// Estimates the remaining time, once enough work is done.
class Estimate {
 public:
  std::string remaining_time_text(double done) const {
    const double passed = seconds_since(begun_);
    if (done < kFirstEstimate || passed < kShort || done >= 1.0) return "";
    return fmt::format(", about {:.0f} s left", passed * (1.0 - done) / done);
  }

 private:
  Clock::time_point begun_ = Clock::now();
};

// One progress bar for all of the work, which never moves backwards.
class Bar {
 public:
  void operator()(const std::string& what, double share) {
    done_ = std::max(done_, std::clamp(share, 0.0, 1.0));
    if (share < 1.0 && drawn_ && seconds_since(*drawn_) < kRedraw) return;
    drawn_ = Clock::now();
    const int filled = static_cast<int>(kBarWidth * done_);
    const std::string left = estimate_.remaining_time_text(done_);
    const bool colour = std::getenv("NO_COLOR") == nullptr;
    to_standard_error("{}[{}{:<{}}{}] {:3.0f} % {}{}", kClearLine, colour ? "\033[36m" : "",
               std::string(static_cast<std::size_t>(filled), '#'), kBarWidth, colour ? "\033[0m" : "",
               100.0 * done_, what.substr(0, kLongest), left);
    if (share >= 1.0) to_standard_error("{}", kClearLine);
    std::fflush(stderr);
  }

 private:
  double done_ = 0.0;
  Estimate estimate_;
  std::optional<Clock::time_point> drawn_;
};

// Prints one line for every stage (the part of the activity before its colon), and further lines from time to time.
class Lines {
 public:
  void operator()(const std::string& what, double share) {
    const std::string stage = what.substr(0, what.find(':'));
    if (stage == stage_ && seconds_since(said_) < kQuietFor) return;
    stage_ = stage;
    said_ = Clock::now();
    print_message(what + estimate_.remaining_time_text(share));
  }

 private:
  std::string stage_;
  Clock::time_point said_;
  Estimate estimate_;
};

std::map<std::string, std::string>& reasons() {
  static std::map<std::string, std::string> all;
  return all;
}

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

std::string command_line(const std::vector<std::string>& words) {
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : " ") + quoted(word);
  return out;
}

void print_message(const std::string& line) {
  to_standard_error("{}veridyn: {}\n", on_terminal() ? kClearLine : "", excerpt(line, line.size()));
}

void explain_refusal(const std::string& file, const std::string& sentence) {
  reasons().emplace(file, sentence);
}

std::string with_registered_reason(const std::string& refusal) {
  for (const auto& [file, sentence] : reasons()) {
    if (refusal.rfind(file + ": ", 0) == 0) return refusal + " " + sentence;
  }
  return refusal;
}

void clear_bar() {
  if (on_terminal()) to_standard_error("{}", kClearLine);
}

Progress progress(const CommonOptions& options) {
  if (options.quiet) return {};
  if (on_terminal()) return Bar();
  return Lines();
}

Busy::Busy(const CommonOptions& options, std::string what) : what_(std::move(what)) {
  if (!options.quiet) shown_ = std::thread([this] { show(); });
}

Busy::~Busy() {
  if (!shown_.joinable()) return;
  {
    const std::lock_guard<std::mutex> lock(guard_);
    done_ = true;
  }
  over_.notify_one();
  shown_.join();
}

void Busy::show() {
  std::unique_lock<std::mutex> lock(guard_);
  const bool terminal = on_terminal();
  for (int seconds = 1; !over_.wait_for(lock, std::chrono::seconds(1), [this] { return done_; }); ++seconds) {
    if (terminal) {
      to_standard_error("{}{}, {} s", kClearLine, what_, seconds);
      std::fflush(stderr);
    } else if (seconds == 1) {
      print_message(what_);
    }
  }
  if (terminal) to_standard_error("{}", kClearLine);
}

}  // namespace veridyn::cli
