#pragma once

#include "veridyn/identification/recording.hpp"

namespace veridyn {

/// What a recording says without the rows that a late publisher wrote twice.
struct RepairedRecording {
  Recording recording;
  long repaired = 0;  ///< rows that were filled in
};

/// Fills in rows that repeat the row before in every signal although the arm moves: positions on
/// the cubic through the sound rows around them and their velocities (straight lines where none
/// are recorded), every other signal on straight lines.
///
/// Repeats of more than a tenth of a second, at the end of the recording, or between equal
/// positions (an arm at rest) stay as they are. So do rows with gaps.
RepairedRecording without_stale_rows(Recording recording);

}  // namespace veridyn
