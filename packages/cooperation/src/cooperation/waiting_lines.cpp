#include "waiting_lines.hpp"

#include <sstream>
#include <utility>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr std::size_t kMost = 10000;  // largest number of waiting lines
constexpr int kAtOnce = 256;          // largest number of lines read in one cycle
constexpr double kOneBreath = 0.05;   // [s] a stop within this time comes from a script, not from a person

bool is_stop(const std::string& line) {
  std::istringstream words(line);
  std::string first, more;
  return words >> first && first == "stop" && !(words >> more);
}

}  // namespace

std::string dropped_lines_message(int count) {
  return text("stopped: ", count, count == 1 ? " line" : " lines", " before it had not been carried out and ",
              count == 1 ? "is" : "are", " dropped.");
}

bool WaitingLines::next(std::string& line) {
  if (lines_.empty()) {
    if (!source_.next(line)) return false;
    taken_arrived_ = now_;
    return true;
  }
  line = std::move(lines_.front().words);
  taken_arrived_ = lines_.front().arrived;
  lines_.pop_front();
  return true;
}

std::optional<int> WaitingLines::stopped(double now) {
  if (source_.is_script()) return std::nullopt;
  now_ = now;
  std::string line;
  for (int k = 0; k < kAtOnce && lines_.size() < kMost && source_.next(line); ++k) {
    const double oldest = taken_arrived_ ? *taken_arrived_ : lines_.empty() ? -kOneBreath : lines_.front().arrived;
    if (!is_stop(line) || now - oldest < kOneBreath) {
      lines_.push_back({std::move(line), now});
      continue;
    }
    const auto dropped = static_cast<int>(lines_.size());
    lines_.clear();
    return dropped;
  }
  return std::nullopt;
}

}  // namespace veridyn
