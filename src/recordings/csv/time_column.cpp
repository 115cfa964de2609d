#include "recordings/csv/time_column.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <ctime>
#include <limits>
#include <map>
#include <set>

#include "math/median.hpp"
#include "recordings/signals/joint_fields.hpp"
#include "recordings/signals/units.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::recordings {
namespace {

constexpr std::int64_t kSecond = 1000000000;

// The unit that a word names, in nanoseconds, or 0.
std::int64_t unit_in_nanoseconds(const std::string& word) {
  static const std::map<std::string, std::int64_t> kUnits = {
      {"ns", 1}, {"nsec", 1}, {"nsecs", 1}, {"nanoseconds", 1},
      {"us", 1000}, {"usec", 1000}, {"microseconds", 1000},
      {"ms", 1000000}, {"msec", 1000000}, {"millis", 1000000}, {"milliseconds", 1000000},
      {"s", kSecond}, {"sec", kSecond}, {"secs", kSecond}, {"seconds", kSecond}};
  const auto found = kUnits.find(word);
  return found == kUnits.end() ? 0 : found->second;
}

bool is_time_word(const std::string& word) {
  static const std::set<std::string> kWords = {"time", "t", "timestamp", "stamp", "times", "clock", "timestamps", "zeit", "zeitstempel"};
  return kWords.count(word) > 0;
}

// Score that rates a column name as the name of a clock; 0: it is none.
int time_name_score(const std::vector<std::string>& words) {
  if (words.empty() || words.size() > 4) return 0;
  const bool only_unit = words.size() == 1 && unit_in_nanoseconds(words[0]) != 0;
  if (!only_unit && std::none_of(words.begin(), words.end(), is_time_word)) return 0;
  return 10 - static_cast<int>(words.size());
}

// [ns] of one unit of the times, by the size of the first ones.
std::int64_t likely_unit(const std::vector<double>& first_times, bool whole_numbers) {
  const double first = first_times.front();
  if (first > 1e17) return 1;
  if (first > 1e14) return 1000;
  if (first > 1e11) return 1000000;
  if (first > 1e8 || !whole_numbers) return kSecond;
  const double step = median_step(first_times);
  if (step >= 1e5) return 1;  // rates of 10 kHz and less, for steps in nanoseconds
  if (step >= 100.0) return 1000;
  return step >= 1.0 ? 1000000 : kSecond;
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
    // A time in two columns, "sec" and "nsec", after the same other words.
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

std::int64_t time_unit(const SignalChoice& choice, std::int64_t named, const std::vector<double>& first_times, bool whole_numbers,
                       std::vector<std::string>* remarks) {
  const auto given = choice.units.find("t");
  if (given != choice.units.end()) return std::llround(unit_factor("t", given->second).value_or(1.0) * kSecond);
  if (named != 0) return named;
  const std::int64_t unit = first_times.size() < 2 ? kSecond : likely_unit(first_times, whole_numbers);
  if (unit != kSecond)
    remarks->push_back(text("times are taken for ", unit == 1 ? "nanoseconds" : unit == 1000 ? "microseconds" : "milliseconds",
                            " by their size (--units t=s says otherwise)."));
  return unit;
}

std::optional<std::int64_t> date_nanoseconds(std::string_view text) {
  const char* p = text.data();
  const char* const end = p + text.size();
  // Parses a number of `digits` digits that is followed by one of `signs`.
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
  std::tm date{};
  date.tm_year = static_cast<int>(year - 1900);
  date.tm_mon = static_cast<int>(month - 1);
  date.tm_mday = static_cast<int>(day);
  return (timegm(&date) + ((hour * 60 + minute - zone) * 60 + second)) * kSecond + fraction;
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
