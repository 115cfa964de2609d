#include "recordings/csv/time_column.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>

#include "recordings/signals/joint_fields.hpp"

namespace veridyn::recordings {
namespace {

constexpr std::int64_t kSecond = 1000000000;

std::int64_t unit_in_nanoseconds(const std::string& word) {
  if (word == "ns" || word == "nsec" || word == "nsecs" || word == "nanoseconds") return 1;
  if (word == "us" || word == "usec" || word == "microseconds") return 1000;
  if (word == "ms" || word == "msec" || word == "millis" || word == "milliseconds") return 1000000;
  if (word == "s" || word == "sec" || word == "secs" || word == "seconds") return kSecond;
  return 0;
}

bool is_time_word(const std::string& word) {
  return word == "time" || word == "t" || word == "timestamp" || word == "stamp" ||
         word == "times" || word == "clock" || word == "timestamps" || word == "zeit";
}

// Score of a column name as the name of a clock; 0: it is none.
int time_name_score(const std::vector<std::string>& words) {
  if (words.empty() || words.size() > 4) return 0;
  bool time = false;
  for (const std::string& word : words) time = time || is_time_word(word);
  const bool only_unit = words.size() == 1 && unit_in_nanoseconds(words[0]) != 0;
  if (!time && !only_unit) return 0;
  return 10 - static_cast<int>(words.size());
}

}  // namespace

TimeColumns time_columns(const std::vector<std::string>& names, const std::string& wanted) {
  TimeColumns columns;
  int best = 0;
  std::optional<int> seconds;
  std::optional<int> fraction;
  for (std::size_t k = 0; k < names.size(); ++k) {
    const auto column = static_cast<int>(k);
    const std::vector<std::string> words = words_of(names[k]);
    if (!wanted.empty() && names[k] == wanted) {
      columns.recorded = column;
      best = 100;
    }
    if (names[k] == "field.header.stamp" || names[k] == "header.stamp") {
      columns.stamped = column;
      continue;
    }
    if (words.empty()) continue;
    // A stamp in two columns: sec and nsec after the same words.
    const std::string& last = words.back();
    const bool of_stamp = words.size() > 1 && is_time_word(words[words.size() - 2]);
    if (of_stamp && (last == "sec" || last == "secs")) seconds = column;
    if (of_stamp && (last == "nsec" || last == "nsecs" || last == "nanosec")) fraction = column;
    const int fit = time_name_score(words);
    if (fit > best && field_of(names[k]).signal < 0) {
      best = fit;
      columns.recorded = column;
      columns.unit = words.size() > 1 || !is_time_word(last) ? unit_in_nanoseconds(last) : 0;
    }
  }
  if (seconds && fraction && best < 9) {
    columns.recorded = seconds;
    columns.nanoseconds = fraction;
    columns.unit = kSecond;
  }
  if (columns.recorded && names[*columns.recorded] == "%time")
    columns.unit = 1;
  if (!columns.recorded) std::swap(columns.recorded, columns.stamped);
  return columns;
}

std::int64_t likely_time_unit(double first, double median_step, bool whole_numbers) {
  if (first > 1e17) return 1;
  if (first > 1e14) return 1000;
  if (first > 1e11) return 1000000;
  if (first > 1e8) return kSecond;
  if (!whole_numbers) return kSecond;
  if (median_step >= 1e5) return 1;     // steps of 10 kHz and slower in ns
  if (median_step >= 100.0) return 1000;
  return median_step >= 1.0 ? 1000000 : kSecond;
}

std::optional<std::int64_t> date_nanoseconds(std::string_view text) {
  const char* p = text.data();
  const char* const end = p + text.size();
  // A number with some digits, followed by one of `signs`.
  const auto part = [&](int digits, const char* signs, std::int64_t* value) {
    const auto [rest, error] = std::from_chars(p, end, *value);
    if (error != std::errc() || rest - p != digits || *p == '-') return false;
    p = rest;
    if (*signs == 0) return true;
    if (p == end || std::strchr(signs, *p) == nullptr) return false;
    ++p;
    return true;
  };
  std::int64_t year = 1970, month = 1, day = 1, hour = 0, minute = 0, second = 0;
  const bool dated = text.size() > 4 && (text[4] == '-' || text[4] == '/');
  if (dated && !(part(4, "-/", &year) && part(2, "-/", &month) && part(2, "T ", &day))) return std::nullopt;
  if (!(part(2, ":", &hour) && part(2, ":", &minute) && part(2, "", &second))) return std::nullopt;
  if (month < 1 || month > 12 || day < 1 || day > 31 || hour > 23 || minute > 59 || second > 60) return std::nullopt;
  std::int64_t fraction = 0;
  if (p != end && (*p == '.' || *p == ',')) {
    std::int64_t scale = kSecond;
    for (++p; p != end && *p >= '0' && *p <= '9'; ++p) fraction += (*p - '0') * (scale /= 10);
  }
  std::int64_t zone = 0;  // minutes ahead of UTC
  if (p != end && (*p == 'Z' || *p == 'z')) ++p;
  else if (p != end && (*p == '+' || *p == '-')) {
    const std::int64_t sign = *p++ == '-' ? -1 : 1;
    std::int64_t hours = 0, minutes = 0;
    if (!part(2, "", &hours)) return std::nullopt;
    if (p != end && *p == ':') ++p;
    if (p != end && !part(2, "", &minutes)) return std::nullopt;
    zone = sign * (60 * hours + minutes);
  }
  if (p != end) return std::nullopt;
  // Days since 1970 of the Gregorian calendar; years begin in March, so that leap days come last.
  const std::int64_t y = month > 2 ? year : year - 1;
  const std::int64_t era = y / 400, of_era = y % 400;
  const std::int64_t of_year = (153 * (month + (month > 2 ? -3 : 9)) + 2) / 5 + day - 1;
  const std::int64_t days = era * 146097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719468;
  return (((days * 24 + hour) * 60 + minute - zone) * 60 + second) * kSecond + fraction;
}

std::optional<std::int64_t> nanoseconds_of(const std::string& number, std::int64_t unit) {
  if (number.find(':') != std::string::npos) return date_nanoseconds(number);
  const char* p = number.data() + (number.rfind('+', 0) == 0 ? 1 : 0);
  const char* end = number.data() + number.size();
  std::int64_t whole = 0;
  const auto [rest, error] = std::from_chars(p, end, whole);
  const std::int64_t largest = std::numeric_limits<std::int64_t>::max() / unit - 1;
  if (error == std::errc() && -largest < whole && whole < largest) {
    if (rest == end) return whole * unit;
    if (*rest == '.' && number.find_first_of("eE") == std::string::npos) {
      std::int64_t fraction = 0;
      std::int64_t scale = unit;
      const char* digit = rest + 1;
      for (; digit != end && *digit >= '0' && *digit <= '9'; ++digit) {
        scale /= 10;
        fraction += (*digit - '0') * scale;
      }
      if (digit != end) return std::nullopt;
      return *p == '-' ? whole * unit - fraction : whole * unit + fraction;
    }
  }
  double value = 0.0;
  const auto [stop, bad] = std::from_chars(p, end, value);
  if (bad != std::errc() || stop != end || !std::isfinite(value)) return std::nullopt;
  const double scaled = value * static_cast<double>(unit);
  if (std::abs(scaled) > 9e18) return std::nullopt;
  return static_cast<std::int64_t>(std::llround(scaled));
}

}  // namespace veridyn::recordings
