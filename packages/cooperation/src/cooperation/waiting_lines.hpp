#pragma once

#include <deque>
#include <optional>
#include <string>

#include "veridyn/cooperation/live.hpp"

namespace veridyn {

/// Lines of a source, in order, of which a stop is seen as soon as it arrives. Not more than 10,000 lines are
/// read ahead.
///
/// A stop that was sent in one breath with the line that is being carried out (50 ms), as by a script through a
/// pipe, has its turn behind the lines between them.
class WaitingLines {
 public:
  explicit WaitingLines(LineSource& source) : source_(source) {}

  /// The next line, as LineSource::next().
  bool next(std::string& line);
  bool closed() const { return source_.closed() && lines_.empty(); }

  /// Call it before every next(). @param now [s]
  /// @returns  once for each stop that has arrived: the number of lines before it that were not taken, which are
  /// dropped. Nothing of a file, in which it has its turn.
  std::optional<int> stopped(double now);

 private:
  struct Line {
    std::string words;
    double arrived;  // [s]
  };
  LineSource& source_;
  std::deque<Line> lines_;
  double now_ = 0.0;
  std::optional<double> taken_arrived_;  // of the line that was taken last
};

/// What is told of lines that a stop dropped.
std::string dropped_lines(int count);

}  // namespace veridyn
