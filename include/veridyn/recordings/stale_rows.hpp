#pragma once

#include <functional>
#include <string>

#include "veridyn/recordings/recording.hpp"

namespace veridyn {

/// Rows that a late publisher repeated and that were interpolated.
struct FilledRows {
  long count = 0;
  double age = 0.0;  ///< [s] age of their data, summed over these rows

  /// [s] mean age of their data; 0 if there are none.
  double lateness() const { return count > 0 ? age / static_cast<double>(count) : 0.0; }
};

/// A clause for reports: "12 % of the rows repeated the row before, 6.9 ms late on average, and are
/// filled in".
std::string filled_text(const FilledRows& filled, long rows);

/// A stream of rows in which those that a late publisher repeated are interpolated.
///
/// A row is stale if it repeats the previous row in every signal although the arm moves (its velocity is not
/// zero, or, without recorded velocities, its position changes afterwards). The signals of one row may arrive
/// in several messages and catch up at different rows; so each signal is interpolated from its last new value
/// before a stale row to its first new one after it: positions on the cubic through both with their
/// velocities (linearly without recorded velocities; the cubic is monotone for any velocities), every other
/// signal linearly.
///
/// Repeats of more than a tenth of a second, at the end of the recording, or beside gaps are kept.
/// A recording without stale rows passes through unchanged, bit for bit. Memory: the requested
/// rows, and a fifth of a second.
class SoundRows {
 public:
  using Source = std::function<Recording(int rows)>;  ///< the next rows, empty at the end

  explicit SoundRows(Source source);

  /// The next rows, as many as requested; fewer only where the recording ends.
  Recording next(int rows);

  /// The interpolated rows among those returned so far.
  const FilledRows& filled() const { return filled_; }

 private:
  int settled_rows() const;
  void clear_position_history();

  Source source_;
  Recording held_;  ///< recorded rows: some returned already, kept as neighbours, then new ones
  int given_ = 0;   ///< rows of held_ that were returned already
  bool ended_ = false;
  FilledRows filled_;
};

}  // namespace veridyn
