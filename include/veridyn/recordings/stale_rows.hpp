#pragma once

#include <functional>
#include <string>

#include "veridyn/recordings/recording.hpp"

namespace veridyn {

/// What a late publisher left behind: rows that were filled in.
struct FilledRows {
  long count = 0;
  double age = 0.0;  ///< [s] of what these rows showed, summed over them

  /// [s] How old what they showed was, on average; 0 if there are none.
  double lateness() const { return count > 0 ? age / static_cast<double>(count) : 0.0; }
};

/// One clause for a reader: "12 % of the rows repeated the row before, 6.9 ms late on average, and
/// are filled in".
std::string filled_text(const FilledRows& filled, long rows);

/// Rows on their way from a file to whoever prepares them; those that a late publisher wrote twice
/// are filled in.
///
/// A row is stale if it repeats the row before in every signal although the arm moves (its velocity
/// is not zero, or its position is another one afterwards where no velocities are recorded). The
/// signals of one row may come by several messages and catch up at different rows; so each signal
/// is filled in from its own last new value before a stale row to its first new one behind it:
/// positions on the cubic through both and their velocities (straight lines where none are
/// recorded; it never turns back, whatever the velocities say), every other signal on straight
/// lines.
///
/// Repeats of more than a tenth of a second, at the end of the recording, or beside gaps stay as
/// they are. A recording without stale rows passes through unchanged, bit for bit. Memory: the rows
/// asked for, and a fifth of a second.
class SoundRows {
 public:
  using Source = std::function<Recording(int rows)>;  ///< the next rows, empty at the end

  explicit SoundRows(Source source);

  /// The next rows, as many as asked for; fewer only where the recording ends.
  Recording next(int rows);

  /// Those among the rows given out so far.
  const FilledRows& filled() const { return filled_; }

 private:
  int settled() const;
  void forget();

  Source source_;
  Recording held_;  ///< as recorded: rows given out already, for their neighbours, and new ones
  int given_ = 0;   ///< Rows of held_ given out already
  bool ended_ = false;
  FilledRows filled_;
};

}  // namespace veridyn
