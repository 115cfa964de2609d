#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "recordings/signals/raw_recording.hpp"

namespace veridyn::recordings {

/// The rows of a stream in the order of their time.
struct StreamClock {
  std::vector<std::int64_t> time;      ///< [ns] strictly increasing
  std::vector<std::size_t> rows;       ///< rows of the stream, one for each time
  std::int64_t recorded_after = 0;     ///< [ns] median of recorded minus stamped; 0 without stamps
  std::vector<std::string> remarks;
};

/// Determines the times of a stream's rows.
///
/// The sender's stamps are used if nearly all exist and increase. A row with a missing or decreasing stamp
/// gets its recording time minus the usual delay, if that lies between its neighbours. Otherwise the sorted
/// recording times are used. A row with the time of the previous one is dropped if it also has the same
/// values; otherwise such rows are spread evenly up to the next time.
/// @throws InvalidInput  the clock runs backwards for longer than a few rows.
StreamClock clock_of(const RawStream& stream, const std::string& where);

}  // namespace veridyn::recordings
