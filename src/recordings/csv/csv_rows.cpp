#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <optional>

#include <fmt/format.h>

#include "model/excerpt.hpp"
#include "recordings/csv/csv_layout.hpp"
#include "recordings/csv/csv_lines.hpp"
#include "veridyn/recordings/recording.hpp"
#include "recordings/csv/row_source.hpp"
#include "recordings/csv/time_column.hpp"
#include "recordings/signals/units.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr double kGap = std::numeric_limits<double>::quiet_NaN();

bool is_blank(char c) {
  return c == ' ' || c == '\t';
}

// Parses one line into a row of numbers.
class RowParser {
 public:
  /// @param first_date  of the file; set by its first date, to which all times are relative.
  RowParser(const CsvLayout& layout, const CsvLines& lines, std::optional<std::int64_t>& first_date)
      : layout_(layout), lines_(lines), first_date_(first_date) {}

  void parse(std::string_view line, std::vector<double>* row) {
    line_ = line;
    p_ = line.data();
    end_ = line.data() + line.size();
    const std::size_t columns = layout_.slots.size();
    if (layout_.separator == ' ') skip_blanks();
    for (std::size_t column = 0; column < columns; ++column) {
      if (column > 0) skip_separator(column);
      const int slot = layout_.slots[column];
      if (slot == CsvLayout::kIgnored) {
        skip_field();
      } else {
        (*row)[slot] = slot == CsvLayout::kTime && is_date() ? seconds(column) : number(column);
      }
    }
    if (layout_.separator == ' ') skip_blanks();
    if (p_ != end_) fail_ragged();
  }

 private:
  bool at_field_end() const {
    return p_ == end_ || *p_ == layout_.separator || (layout_.separator == ' ' && *p_ == '\t');
  }

  void skip_blanks() {
    while (p_ != end_ && is_blank(*p_)) ++p_;
  }

  // Skips blanks that are no separators.
  void skip_padding() {
    while (p_ != end_ && is_blank(*p_) && !at_field_end()) ++p_;
  }

  void skip_separator(std::size_t column) {
    if (!at_field_end()) fail_text(column - 1);
    if (p_ == end_) fail_ragged();
    ++p_;
    if (layout_.separator != ' ') return;
    skip_blanks();
    if (p_ == end_) fail_ragged();
  }

  void skip_field() {
    bool quoted = false;
    for (; p_ != end_ && (quoted || !at_field_end()); ++p_) {
      if (*p_ == '"') quoted = !quoted;
    }
  }

  // Numbers have no colon; a date has one within its first 14 characters.
  bool is_date() const {
    const char* stop = std::min(end_, p_ + 15);
    for (const char* c = p_; c < stop && *c != layout_.separator; ++c) {
      if (*c == ':') return true;
    }
    return false;
  }

  double seconds(std::size_t column) {
    skip_padding();
    const char* first = p_;
    skip_field();
    std::string_view date(first, static_cast<std::size_t>(p_ - first));
    while (!date.empty() && (date.front() == '"')) date.remove_prefix(1);
    while (!date.empty() && (date.back() == '"' || is_blank(date.back()))) date.remove_suffix(1);
    const std::optional<std::int64_t> found = recordings::date_nanoseconds(date);
    if (!found) {
      p_ = first;
      fail_text(column);
    }
    if (!first_date_) first_date_ = found;
    return 1e-9 * static_cast<double>(*found - *first_date_);
  }

  double number(std::size_t column) {
    skip_padding();
    if (at_field_end()) return kGap;
    const char* const first = p_;
    double value = 0.0;
    const auto [rest, error] = std::from_chars(p_, end_, value);
    p_ = rest;
    skip_padding();
    if (error == std::errc() && at_field_end()) return value;
    // The slow path: quotes, a decimal comma, or a word for a missing value.
    p_ = first;
    skip_field();
    std::string field(first, p_);
    field.erase(0, field.find_first_not_of("\" \t"));
    field.erase(field.find_last_not_of("\" \t") + 1);
    const bool is_word = layout_.slots[column] == CsvLayout::kTime && is_missing_value(field);
    if (is_word || !csv_number(std::move(field), layout_.separator, &value)) {
      p_ = first;
      fail_text(column);
    }
    return value;
  }

  [[noreturn]] void fail_text(std::size_t column) {
    const char* first = p_;
    skip_field();
    const std::string found = excerpt(std::string(first, static_cast<std::size_t>(p_ - first)), 40);
    throw InvalidInput(text(where(), ":", column + 1, ": found '", found, "' in column ",
                            layout_.names[column], layout_.slots[column] == CsvLayout::kTime
                                ? ", expected a number of seconds or a date as 2025-05-28T12:00:46.628."
                                : ", expected a number."));
  }

  [[noreturn]] void fail_ragged() const {
    throw InvalidInput(text(where(), ": found ", csv_fields(line_, layout_.separator).size(),
                            " fields, expected ", layout_.slots.size(), "."));
  }

  std::string where() const { return text(lines_.path(), ":", lines_.number()); }

  const CsvLayout& layout_;
  const CsvLines& lines_;
  std::optional<std::int64_t>& first_date_;
  std::string_view line_;
  const char* p_ = nullptr;
  const char* end_ = nullptr;
};

// True if the columns are given as "q1,dq1,tau1,q2,..." and not as "q,dq,tau".
bool name_each_joint(const std::vector<std::string>& columns) {
  return std::any_of(columns.begin(), columns.end(), [](const std::string& name) {
    return !name.empty() && name.back() >= '0' && name.back() <= '9';
  });
}

CsvLayout layout_from_names(const std::vector<std::string>& names, std::string_view line, const std::string& where) {
  std::string header;
  for (const std::string& name : names) header += (header.empty() ? "" : ",") + name;
  const std::size_t found = csv_fields(line, csv_separator(line)).size();
  require(found == names.size(), where, ": found ", found, " columns, expected the ", names.size(), " of --columns ", header, ".");
  CsvLayout layout = layout_from_header(header, where);
  layout.separator = csv_separator(line);
  return layout;
}

// rows with equal times and different values >= kMostEqual: the times have lost their digits.
constexpr long kMostEqual = 200;
// For a file that ends earlier: > kFewEqual such rows, and more than kDistinct rows for each distinct time.
constexpr long kFewEqual = 10, kDistinct = 20;
// step of a position <= kSteady * the previous step + kSmallStep [rad, m]: the motion continues.
constexpr double kSteady = 5.0, kSmallStep = 2e-3;
// A time that, times a power of 1000, goes on within kSoon steps of the times before, after more than kLater steps: the unit
// of the clock has changed.
constexpr double kSoon = 10.0, kLater = 100.0;
constexpr int kFirstRows = 4096;  // initial capacity of a piece; it doubles, as files may end early

void reserve_rows(const CsvLayout& layout, int rows, Recording& recording) {
  recording.time.conservativeResize(rows);
  for (std::size_t s = 0; s < layout.has_signal.size(); ++s) {
    MatrixXd& values = recording.*kRecordingSignals[s].values;
    if (layout.has_signal[s] || s == 0) values.conservativeResize(rows, layout.joints);
  }
}

}  // namespace

namespace recordings {
namespace {

class CsvRows : public RowSource {
 public:
  CsvRows(CsvLines text, const RecordingOptions& wanted, RowClock of_rows)
      : options(wanted), clock(of_rows), lines(std::move(text)) {
    read_layout();
  }

  Recording next(int rows) override;
  int joints() const override { return layout.joints; }
  RecordingFacts facts() const override;

 private:
  void read_layout();
  bool next_line(std::string_view* line);
  bool next_row();
  bool accept_time();
  bool repeats_before() const;
  bool motion_continues() const;
  void follow_unit(double t);
  void handle_backward_time(double found);
  [[noreturn]] void refuse_time(double found, const std::string& why) const;
  void count_from_here();
  bool hold_gaps();
  void set_scales();
  void parse(std::string_view line);

  RecordingOptions options;
  RowClock clock;
  CsvLines lines;
  CsvLayout layout;
  std::string header;      // line with the names of the columns, or empty
  std::string first_line;  // first row of numbers, if it was read in advance
  bool has_first_line = false;
  std::vector<double> row;  // current row; row[0] is t
  long row_number = 0;      // number of the next row in the file, from 0
  double time = kGap;       // of the last row with a time
  double step = 0.0;
  long gaps_left = 0;  // rows without a time that are still to be returned before held_row
  std::vector<double> held_row;
  std::vector<UnitScale> scales;  // factors to SI for each slot; empty: all are one
  long repeated = 0;       // rows that were dropped because they repeat the time of the previous row
  std::optional<std::int64_t> first_date;  // [ns]
  std::vector<double> before, second_before;  // the last two rows with a time
  long equal = 0, equal_run = 0, timed = 0;  // rows with the time of the previous row and other values; length of their last run; rows with a time
  double moved_on = 0.0;    // [s] added to times after a clock was set back
  double rescaled = 1.0;    // factor of the times after their unit has changed
  double first_time = kGap;
  double counted_time = 0.0;         // [s] time of the previous row
  std::optional<long> counted_from;  // the first row whose time is counted, as for --rate
  std::vector<std::string> remarks;
};

RecordingFacts CsvRows::facts() const {
  RecordingFacts facts;
  facts.format = "CSV";
  for (int joint = 1; joint <= layout.joints; ++joint) {
    const auto named = static_cast<std::size_t>(joint) <= options.signals.joints.size();
    facts.joints.push_back(
        named && options.signals.joints.size() == static_cast<std::size_t>(layout.joints)
            ? options.signals.joints[joint - 1].name
            : std::to_string(joint));
  }
  if (repeated > 0)
    facts.remarks.push_back(text(repeated, repeated == 1 ? " row repeats" : " rows repeat",
                                 " the time stamp before and ", repeated == 1 ? "is" : "are",
                                 " left out."));
  facts.remarks.insert(facts.remarks.end(), remarks.begin(), remarks.end());
  if (first_date) facts.start = 1e-9 * static_cast<double>(*first_date);
  if (options.rate > 0.0 && layout.has_time && !counted_from)
    facts.remarks.push_back("the times of column t grow and are used; --rate is for files without them.");
  return facts;
}

void CsvRows::read_layout() {
  std::string_view line;
  require(lines.next(&line), lines.path(), ": found no row, expected a header and numbers.");
  std::string where = text(lines.path(), ":", lines.number());
  bool numbers = is_row_of_numbers(line);
  if (!options.columns.empty()) {
    if (!numbers) {  // a header, over which options.columns takes precedence
      require(lines.next(&line), where, ": found a header without rows, expected numbers below it.");
      where = text(lines.path(), ":", lines.number());
      numbers = is_row_of_numbers(line);
      require(numbers, where, ": found text in the second line, too, expected numbers.");
    }
    layout = name_each_joint(options.columns) ? layout_from_names(options.columns, line, where)
                                              : layout_from_columns(options.columns, line, where);
  } else if (!numbers) {
    layout = layout_from_header(line, where);
    header.assign(line);
  } else {
    const std::string comment = lines.last_comment();
    const bool in_comment =
        comment.find("q1") != std::string::npos && csv_fields(comment, csv_separator(line)).size() ==
                                                      csv_fields(line, csv_separator(line)).size();
    require(in_comment, where,
            ": found numbers, expected a header; the first line is numbers, so name them with "
            "--columns and --rate.");
    layout = layout_from_header(comment, where);
    layout.separator = csv_separator(line);
  }
  const bool has_word =
      std::find(layout.names.begin(), layout.names.end(), "time") != layout.names.end();
  require(layout.has_time || options.rate > 0.0, where, ": found no column t",
          has_word ? " (but 'time')" : "", ", expected one, or --rate.");
  if (numbers) first_line.assign(line);
  has_first_line = numbers;
  row.assign(static_cast<std::size_t>(layout.slot_count()), kGap);
  set_scales();
}

// Sets the scales from the units of the file to SI, for every slot of a row.
void CsvRows::set_scales() {
  scales.assign(row.size(), {});
  bool any = false;
  const auto unit = options.signals.units.find("t");
  if (unit != options.signals.units.end())
    scales[CsvLayout::kTime].factor = unit_factor("t", unit->second).value_or(1.0);
  for (std::size_t s = 0; s < layout.has_signal.size(); ++s) {
    for (int joint = 0; joint < layout.joints; ++joint)
      scales[static_cast<std::size_t>(layout.slot(static_cast<int>(s), joint))] = scale_for(options.signals, kRecordingSignals[s].name, joint + 1);
  }
  for (const UnitScale& scale : scales) any = any || !scale.changes_nothing();
  if (!any) scales.clear();
}

void CsvRows::parse(std::string_view line) {
  if (!header.empty() && line == header)
    throw InvalidInput(text(lines.path(), ":", lines.number(), ": found the header again, expected numbers; a second recording begins here: --rows 0:", row_number,
                            " reads what is before it, --rows ", row_number + 1, ": the rest."));
  RowParser(layout, lines, first_date).parse(line, &row);
  for (std::size_t k = 0; k < scales.size(); ++k) row[k] = scales[k](row[k]);
}

bool CsvRows::next_line(std::string_view* line) {
  if (!has_first_line) return lines.next(line);
  has_first_line = false;
  *line = first_line;
  return true;
}

bool CsvRows::repeats_before() const {
  for (std::size_t k = 1; k < row.size(); ++k) {
    if (row[k] != before[k] && !(std::isnan(row[k]) && std::isnan(before[k]))) return false;
  }
  return true;
}

void CsvRows::refuse_time(double found, const std::string& why) const {
  const auto column = std::find(layout.slots.begin(), layout.slots.end(), CsvLayout::kTime) - layout.slots.begin();
  throw InvalidInput(fmt::format("{}:{}:{}: found time {:.15g} s after {:.15g} s, expected it to grow; {}", lines.path(), lines.number(), column + 1,
                                 found, time, why));
}

void CsvRows::count_from_here() {
  counted_from = row_number;
  counted_time = time;
  remarks.push_back(text("from row ", row_number, " on the times do not grow: the rows are counted at ", options.rate, " Hz, as --rate says."));
}

bool CsvRows::motion_continues() const {
  bool moves_on = second_before.size() == row.size() && !options.signals.as_recorded;
  for (int joint = 0; moves_on && joint < layout.joints; ++joint) {
    const auto at = static_cast<std::size_t>(layout.slot(0, joint));
    moves_on = std::abs(row[at] - before[at]) <= kSteady * std::abs(before[at] - second_before[at]) + kSmallStep;
  }
  return moves_on;
}

// Times after a clock was set back are shifted, if the arm's motion continues. A clock that starts anew at
// another position begins another recording, which is an error.
void CsvRows::handle_backward_time(double found) {
  const bool moves_on = found > first_time && motion_continues();
  if (!moves_on && row_number < 2) refuse_time(found, text("time runs back: sort the rows by it where they are out of order; where they are not, ", recordings::kCountRows));
  if (!moves_on)
    refuse_time(found, text("a second recording begins at row ", row_number, ": --rows 0:", row_number, " reads what is before it, --rows ", row_number,
                            ": the rest, and ", recordings::kCountRows));
  remarks.push_back(text("the clock steps back by ", time + step - found, " s at row ", row_number, " while the arm moves on: the times behind it are moved on (--as-recorded refuses them)."));
  moved_on += time + step - found;
}

void CsvRows::follow_unit(double t) {
  const auto goes_on = [this](double next) { return next > time && next < time + kSoon * step; };
  if (!(time - first_time > kLater * step) || goes_on(rescaled * t + moved_on) || !motion_continues()) return;
  for (const double factor : {1e-3, 1e3, 1e-6, 1e6, 1e-9, 1e9}) {
    if (!goes_on(factor * rescaled * t + moved_on)) continue;
    rescaled *= factor;
    remarks.push_back(fmt::format("from row {} on the times are in another unit: {} by {:.0f} they go on where those before end (--as-recorded keeps them).",
                                  row_number, factor < 1.0 ? "divided" : "multiplied", std::max(factor, 1.0 / factor)));
    return;
  }
}

// Checks that the row's time increases where it has to. False if the row repeats the previous one.
bool CsvRows::accept_time() {
  double& t = row[CsvLayout::kTime];
  ++timed;
  if (counted_from) {
    t = time = counted_time + static_cast<double>(row_number - *counted_from + 1) / options.rate;
    return true;
  }
  follow_unit(t);
  t = rescaled * t + moved_on;
  if (std::isnan(first_time)) first_time = t;
  if (t == time && (clock == RowClock::kMayBeSetBack || before.size() != row.size() || repeats_before())) {
    ++repeated;
    return false;
  }
  if (!(t > time) && !std::isnan(time) && clock == RowClock::kRises) {
    if (options.rate > 0.0) {
      count_from_here();
      t = time + 1.0 / options.rate;
    } else if (t < time) {
      handle_backward_time(t);
      t = time + step;
    } else {
      ++equal;
      if (++equal_run >= kMostEqual)
        refuse_time(t, text("so do ", equal_run, " rows with other values: the times have lost their digits, and ", recordings::kCountRows));
    }
  }
  if (t > time) equal_run = 0;
  if (!std::isnan(time) && t > time) step = t - time;
  time = t;
  if (clock == RowClock::kRises) {
    second_before.swap(before);
    before = row;
  }
  return true;
}

// Called at a row without a time: reads to the next row with one. False if there is none.
bool CsvRows::hold_gaps() {
  const double last_time = time;
  std::string_view line;
  gaps_left = 0;
  while (!std::isfinite(row[CsvLayout::kTime]) || row[CsvLayout::kTime] == last_time) {
    const bool repeats = row[CsvLayout::kTime] == last_time;
    repeated += repeats ? 1 : 0;
    for (std::size_t k = 1; k < row.size() && !repeats; ++k) {
      require(std::isnan(row[k]), lines.path(), ":", lines.number(), ": found ",
              std::isnan(row[0]) ? "no time" : "infinite time",
              " in a row with numbers, expected a time in seconds.");
    }
    gaps_left += repeats ? 0 : 1;
    ++row_number;
    if (!next_line(&line)) return gaps_left = 0, false;
    parse(line);
  }
  accept_time();
  if (std::isnan(last_time))
    // Rows at the start or end are dropped, because their time cannot be interpolated.
    return gaps_left = 0, true;
  step = (time - last_time) / static_cast<double>(gaps_left + 1);
  held_row = row;
  return true;
}

// Reads the next row into `row`. False at the end of the file.
bool CsvRows::next_row() {
  const long last = !options.row_count ? std::numeric_limits<long>::max()
                                          : options.first_row + *options.row_count;
  if (gaps_left == 0 && !held_row.empty()) {
    row.swap(held_row);
    held_row.clear();
  } else if (gaps_left == 0) {
    std::string_view line;
    for (; row_number < options.first_row; ++row_number) {
      if (!next_line(&line)) return false;
    }
    bool fresh = false;
    while (!fresh) {
      if (row_number >= last || !next_line(&line)) return false;
      parse(line);
      fresh = true;
      if (!layout.has_time) {
        row[CsvLayout::kTime] = static_cast<double>(row_number) / options.rate;
      } else if (std::isfinite(row[CsvLayout::kTime])) {
        fresh = accept_time();
      } else if (!hold_gaps()) {
        return false;
      }
      ++row_number;
    }
  }
  if (row_number - 1 - gaps_left >= last) return false;
  if (gaps_left == 0) return true;
  std::fill(row.begin(), row.end(), kGap);
  row[CsvLayout::kTime] = time - step * static_cast<double>(gaps_left);
  --gaps_left;
  return true;
}

Recording CsvRows::next(int rows) {
  Recording piece;
  piece.source = lines.path();
  int room = std::min(rows, kFirstRows);
  reserve_rows(layout, room, piece);
  int count = 0;
  while (count < rows && next_row()) {
    if (count == room) reserve_rows(layout, room = room > rows / 2 ? rows : 2 * room, piece);
    piece.time[count] = row[CsvLayout::kTime];
    for (std::size_t s = 0; s < layout.has_signal.size(); ++s) {
      if (!layout.has_signal[s]) continue;
      MatrixXd& values = piece.*kRecordingSignals[s].values;
      const double* from = &row[layout.slot(static_cast<int>(s), 0)];
      for (int joint = 0; joint < layout.joints; ++joint) values(count, joint) = from[joint];
    }
    ++count;
  }
  if (count < rows && equal > kFewEqual && kDistinct * (timed - equal) < timed)
    refuse_time(time, text("so do ", equal, " of ", timed, " rows with other values: the times have lost their digits, and ", recordings::kCountRows));
  if (is_current_unit(unit_of(options.signals, "tau", 0)) && piece.tau.size() > 0) {
    piece.current = std::move(piece.tau);
    piece.tau.resize(0, 0);
  }
  return count == room ? piece : rows_of(piece, 0, count);
}

}  // namespace

std::unique_ptr<RowSource> csv_rows(CsvLines lines, const RecordingOptions& options, RowClock clock) {
  return std::make_unique<CsvRows>(std::move(lines), options, clock);
}

}  // namespace recordings
}  // namespace veridyn
