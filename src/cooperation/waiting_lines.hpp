#pragma once

#include <deque>
#include <optional>
#include <string>

#include "veridyn/cooperation/live.hpp"

namespace veridyn {

/// Lines of a source, in order, of which a stop is seen as soon as it arrives. Not more than 10,000 lines are
/// read ahead.
class WaitingLines {
 public:
  explicit WaitingLines(LineSource& source) : source_(source) {}

  /// The next line, as LineSource::next().
  bool next(std::string& line);
  bool closed() const { return source_.closed() && lines_.empty(); }

  /// Call it before every next(). @returns  once for each stop that has arrived: the number of lines before it
  /// that were not taken, which are dropped. Nothing of a script, in which it has its turn.
  std::optional<int> stopped();

 private:
  LineSource& source_;
  std::deque<std::string> lines_;
};

/// What is told of lines that a stop dropped.
std::string dropped_lines(int count);

}  // namespace veridyn
