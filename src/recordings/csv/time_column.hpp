#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace veridyn::recordings {

/// Advice where times do not increase, at the end of a message.
inline constexpr const char* kCountRows = "--rate HZ counts the rows instead.";

/// Columns with a clock.
struct TimeColumns {
  std::optional<int> recorded = {};     ///< the clock of the rows
  std::optional<int> nanoseconds = {};  ///< a second column with the fraction, where `recorded` has seconds
  std::optional<int> stamped = {};      ///< stamps of the sender, in nanoseconds
  std::int64_t unit = 0;         ///< [ns] of `recorded`; 0: unknown from its name
};

/// @param wanted  the column chosen by the user; empty: found by name.
TimeColumns time_columns(const std::vector<std::string>& names, const std::string& wanted);

/// The plausible unit [ns] of these times: nanoseconds since 1970 and the like by their magnitude;
/// milliseconds for whole numbers with steps of 1 or more; else seconds.
std::int64_t likely_time_unit(double first, double median_step, bool whole_numbers);

/// Nanoseconds since 1970 of "2025-05-28 12:00:46.628", "2025-05-28T12:00:46,628Z", "2025/05/28 12:00:46+02:00", or since
/// midnight of "12:00:46.628"; nullopt for other text.
std::optional<std::int64_t> date_nanoseconds(std::string_view text);

/// A date as above, or "1.5" times 10^9 without the rounding of a double; nullopt if the text is no number.
std::optional<std::int64_t> nanoseconds_of(const std::string& number, std::int64_t unit);

}  // namespace veridyn::recordings
