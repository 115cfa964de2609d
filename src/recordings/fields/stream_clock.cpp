#include "recordings/fields/stream_clock.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>

#include "math/median.hpp"
#include "recordings/csv/time_column.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::recordings {
namespace {

constexpr double kMostStamps = 0.9;  // share of rows that must have an increasing stamp
constexpr std::int64_t kRestart = 20;  // a clock that falls by more median steps was restarted
constexpr double kFewBack = 0.01;    // share of rows out of order that are sorted without a remark

// Compares bytes, so that two NaN are equal.
bool same_values(const RawStream& stream, std::size_t a, std::size_t b) {
  const std::size_t width = stream.fields.size();
  return width == 0 || std::memcmp(&stream.values[a * width], &stream.values[b * width],
                                   width * sizeof(double)) == 0;
}

bool stamps_are_sound(const RawStream& stream) {
  if (stream.stamped.size() != stream.rows() || stream.rows() == 0) return false;
  std::size_t good = 0;
  std::int64_t before = 0;
  for (const std::int64_t stamp : stream.stamped) {
    if (stamp <= 0 || stamp < before) continue;
    ++good;
    before = stamp;
  }
  return static_cast<double>(good) >= kMostStamps * static_cast<double>(stream.rows());
}

std::int64_t median_delay(const RawStream& stream) {
  std::vector<std::int64_t> delays;
  for (std::size_t k = 0; k < stream.rows(); ++k) {
    if (stream.stamped[k] > 0) delays.push_back(stream.recorded[k] - stream.stamped[k]);
  }
  return median(std::move(delays));
}

// The stamps; missing or decreasing ones are replaced by recording times.
std::vector<std::int64_t> repaired_stamps(const RawStream& stream, std::int64_t delay,
                                          long* replaced) {
  std::vector<std::int64_t> time = stream.stamped;
  for (std::size_t k = 0; k < time.size(); ++k) {
    const std::int64_t before = k > 0 ? time[k - 1] : 0;
    if (stream.stamped[k] > 0 && stream.stamped[k] > before) continue;
    std::int64_t after = std::numeric_limits<std::int64_t>::max();
    for (std::size_t j = k + 1; j < time.size() && j < k + 16; ++j) {
      if (stream.stamped[j] <= std::max<std::int64_t>(before, 0)) continue;
      after = stream.stamped[j];
      break;
    }
    const std::int64_t guess = stream.recorded[k] - delay;
    if (guess > before && guess < after) {
      time[k] = guess;
      ++*replaced;
    } else if (stream.stamped[k] <= 0 || stream.stamped[k] < before) {
      time[k] = before;
    }
  }
  return time;
}

// Handles rows with the time of the previous row: drops them, or spreads them up to the next time.
void resolve_repeats(const RawStream& stream, StreamClock* clock) {
  std::vector<std::int64_t> time;
  std::vector<std::size_t> rows;
  long same = 0;
  long spread = 0;
  for (std::size_t k = 0; k < clock->time.size();) {
    std::size_t end = k + 1;
    while (end < clock->time.size() && clock->time[end] == clock->time[k]) ++end;
    const std::size_t first = rows.size();
    for (std::size_t j = k; j < end; ++j) {
      if (rows.size() > first && same_values(stream, rows.back(), clock->rows[j])) {
        ++same;
        continue;
      }
      time.push_back(clock->time[k]);
      rows.push_back(clock->rows[j]);
    }
    const auto kept = static_cast<std::int64_t>(rows.size() - first);
    if (kept > 1) {
      const std::int64_t step = end < clock->time.size() ? clock->time[end] - clock->time[k]
                                : first > 0              ? time[first] - time[first - 1]
                                                         : kept * 1000000;
      for (std::int64_t j = 1; j < kept; ++j)
        time[first + static_cast<std::size_t>(j)] += std::max(step / kept * j + step % kept * j / kept, j);
      spread += static_cast<long>(kept) - 1;
    }
    k = end;
  }
  if (same > 0)
    clock->remarks.push_back(text(same, same == 1 ? " row repeats" : " rows repeat",
                                  " the row before with its time stamp and ",
                                  same == 1 ? "is" : "are", " left out."));
  if (spread > 0)
    clock->remarks.push_back(text(spread, spread == 1 ? " row repeats" : " rows repeat",
                                  " the time stamp before with other values: such rows are spread "
                                  "evenly up to the next time."));
  clock->time = std::move(time);
  clock->rows = std::move(rows);
}

}  // namespace

StreamClock clock_of(const RawStream& stream, const std::string& where) {
  StreamClock clock;
  clock.rows.resize(stream.rows());
  std::iota(clock.rows.begin(), clock.rows.end(), std::size_t{0});
  long replaced = 0;
  const bool stamps = stamps_are_sound(stream);
  if (stamps) {
    clock.recorded_after = median_delay(stream);
    clock.time = repaired_stamps(stream, clock.recorded_after, &replaced);
  } else {
    clock.time = stream.recorded;
    if (!stream.stamped.empty() &&
        std::any_of(stream.stamped.begin(), stream.stamped.end(), [](auto s) { return s > 0; }))
      clock.remarks.emplace_back(
          "the sender's time stamps do not grow: the times of recording are used.");
  }
  if (replaced > 0)
    clock.remarks.push_back(text(replaced, replaced == 1 ? " time stamp is" : " time stamps are",
                                 " missing or repeated: the time of recording stands in."));
  long back = 0;
  for (std::size_t k = 1; k < clock.time.size(); ++k) back += clock.time[k] < clock.time[k - 1];
  if (back > 0) {
    const bool bag = !stream.stamped.empty();  // the writer of a bag may interleave messages
    require(bag || static_cast<double>(back) <= std::max(1.0, kFewBack * static_cast<double>(stream.rows())),
            where, ": found ", back, " time stamps that run back, expected a clock that grows; ", kCountRows);
    for (std::size_t k = 1; k < clock.time.size() && !bag; ++k) {
      const std::int64_t fall = clock.time[k - 1] - clock.time[k];
      require(fall < kRestart * median_step(clock.time), where, ": found time ", 1e-9 * static_cast<double>(clock.time[k]), " s after ",
              1e-9 * static_cast<double>(clock.time[k - 1]), " s at row ", k, ", expected it to grow; two recordings in one file? ", kCountRows);
    }
    std::stable_sort(clock.rows.begin(), clock.rows.end(),
                     [&](std::size_t a, std::size_t b) { return clock.time[a] < clock.time[b]; });
    std::vector<std::int64_t> sorted(clock.time.size());
    for (std::size_t k = 0; k < sorted.size(); ++k) sorted[k] = clock.time[clock.rows[k]];
    clock.time = std::move(sorted);
    clock.remarks.push_back(text(back, back == 1 ? " row was" : " rows were",
                                 " out of order and sorted by time."));
  }
  resolve_repeats(stream, &clock);
  return clock;
}

}  // namespace veridyn::recordings
