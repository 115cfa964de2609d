#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "veridyn/recordings/signal_choice.hpp"

namespace veridyn::recordings {

/// Advice at the end of a message about times that do not increase.
inline constexpr const char* kCountRows = "--rate HZ counts the rows instead.";

/// Columns with a clock.
struct TimeColumns {
  std::optional<int> recorded = {};     ///< the clock of the rows
  std::optional<int> nanoseconds = {};  ///< column with the fraction [ns], if `recorded` has seconds
  std::optional<int> stamped = {};      ///< column of the sender's stamps [ns]
  std::int64_t unit = 0;         ///< [ns] unit of `recorded`; 0: the name does not contain it
};

/// @param wanted  the column chosen by the user; empty: found by name.
TimeColumns time_columns(const std::vector<std::string>& names, const std::string& wanted);

/// Number of times at the start of a clock from which time_unit() finds the unit.
inline constexpr std::size_t kTimesForUnit = 400;

/// The unit [ns] of a clock: given by --units, or `named` by the file, or the most plausible one for its first
/// times, with a remark: nanoseconds (or micro-, milliseconds) since 1970 by their magnitude; milliseconds for
/// whole numbers with steps of 1 or more; else seconds.
/// @param named  0: the file does not contain the unit.
std::int64_t time_unit(const SignalChoice& choice, std::int64_t named, const std::vector<double>& first_times, bool whole_numbers,
                       std::vector<std::string>* remarks);

/// Nanoseconds since 1970 of "2025-05-28 12:00:46.628", "2025-05-28T12:00:46,628Z", "2025/05/28 12:00:46+02:00", or since
/// midnight of "12:00:46.628"; nullopt for other text.
std::optional<std::int64_t> date_nanoseconds(std::string_view text);

/// Converts a date as above, or "1.5" times `unit`, without the rounding errors of a double; nullopt for text
/// that is no number.
std::optional<std::int64_t> nanoseconds_of(const std::string& number, std::int64_t unit);

}  // namespace veridyn::recordings
