#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "recordings/signals/raw_recording.hpp"

namespace veridyn::recordings {

/// The rows of a stream in the order of their time.
struct StreamClock {
  std::vector<std::int64_t> time;      ///< [ns] strictly increasing
  std::vector<std::size_t> rows;       ///< Rows of the stream, one for each time
  std::int64_t recorded_after = 0;     ///< [ns] median of recorded minus stamped; 0 without stamps
  std::vector<std::string> remarks;
};

/// When the rows of a stream happened.
///
/// The sender's stamps are used where nearly all are there and grow; a row whose stamp is missing
/// or does not grow takes its recorded time, less what rows usually take to be recorded, if that
/// fits between its neighbours. Otherwise the recorded times are used, sorted. Rows that repeat the
/// time before are left out if they repeat its values, too, and spread evenly up to the next time
/// if not.
/// @throws InvalidInput  the clock runs back for longer than a few rows.
StreamClock clock_of(const RawStream& stream, const std::string& where);

}  // namespace veridyn::recordings
