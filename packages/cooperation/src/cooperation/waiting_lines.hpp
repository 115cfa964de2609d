#pragma once

#include <deque>
#include <optional>
#include <string>

#include "veridyn/cooperation/live.hpp"

namespace veridyn {

/// Lines of a source, in order; a stop is reported as soon as it arrives. At most 10,000 lines are
/// read ahead.
///
/// A stop that arrives within 50 ms of the line that is being executed, as from a script through a
/// pipe, is executed after the lines between them.
class WaitingLines {
 public:
  explicit WaitingLines(LineSource& source) : source_(source) {}

  /// The next line, as LineSource::next().
  bool next(std::string& line);
  bool closed() const { return source_.closed() && lines_.empty(); }

  /// Call it before every next(). @param now [s]
  /// @returns  once for each stop that has arrived: the number of earlier lines that were not executed, which
  /// are dropped. Nullopt for a file, in which stops are executed in order.
  std::optional<int> stopped(double now);

 private:
  struct Line {
    std::string words;
    double arrived;  // [s] time of arrival
  };
  LineSource& source_;
  std::deque<Line> lines_;
  double now_ = 0.0;
  std::optional<double> taken_arrived_;  // [s] arrival of the last line that was returned
};

/// Message about lines that a stop dropped.
std::string dropped_lines_message(int count);

}  // namespace veridyn
