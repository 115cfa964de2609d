#include "waiting_lines.hpp"

#include <sstream>
#include <utility>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr std::size_t kMost = 10000;  // lines that wait
constexpr int kAtOnce = 256;          // lines that are read in one cycle

bool is_stop(const std::string& line) {
  std::istringstream words(line);
  std::string first, more;
  return words >> first && first == "stop" && !(words >> more);
}

}  // namespace

std::string dropped_lines(int count) {
  return text("stopped: ", count, count == 1 ? " line" : " lines", " before it had not been carried out and ",
              count == 1 ? "is" : "are", " dropped.");
}

bool WaitingLines::next(std::string& line) {
  if (lines_.empty()) return source_.next(line);
  line = std::move(lines_.front());
  lines_.pop_front();
  return true;
}

std::optional<int> WaitingLines::stopped() {
  if (source_.is_script()) return std::nullopt;
  std::string line;
  for (int k = 0; k < kAtOnce && lines_.size() < kMost && source_.next(line); ++k) {
    if (!is_stop(line)) {
      lines_.push_back(std::move(line));
      continue;
    }
    const auto dropped = static_cast<int>(lines_.size());
    lines_.clear();
    return dropped;
  }
  return std::nullopt;
}

}  // namespace veridyn
