#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

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

// Parses one line into a row of numbers.
class RowParser {
 public:
  /// @param first_date  date of the file's first row with one; set by this parser. All times are relative to
  ///   it.
  RowParser(const CsvLayout& layout, const CsvLines& lines, std::optional<std::int64_t>& first_date)
      : layout_(layout), lines_(lines), first_date_(first_date) {}

  void parse_row(std::string_view line, std::vector<double>* row) {
    line_ = line;
    p_ = line.data();
    end_ = line.data() + line.size();
    const std::size_t columns = layout_.slots.size();
    if (layout_.separator == ' ') skip_blanks();
    for (std::size_t column = 0; column < columns; ++column) {
      if (column > 0) skip_separator(column);
      if (layout_.slots[column] == CsvLayout::kIgnored) {
        skip_field();
      } else {
        (*row)[layout_.slots[column]] = parsed_number(column);
      }
    }
    if (layout_.separator == ' ') skip_blanks();
    if (p_ != end_) fail_ragged();
  }

 private:
  static bool is_blank(char c) { return c == ' ' || c == '\t'; }

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

  // The number of a field; kGap if it is empty.
  double parsed_number(std::size_t column) {
    skip_padding();
    if (at_field_end()) return kGap;
    const char* const first = p_;
    double value = 0.0;
    const auto [rest, error] = std::from_chars(p_, end_, value);
    p_ = rest;
    skip_padding();
    if (error == std::errc() && at_field_end()) return value;
    p_ = first;
    return unusual_number(column);
  }

  // The number in a field with quotes, a decimal comma, a date, or a word for a missing value.
  double unusual_number(std::size_t column) {
    const char* const first = p_;
    skip_field();
    std::string field(first, p_);
    field.erase(0, field.find_first_not_of("\" \t"));
    field.erase(field.find_last_not_of("\" \t") + 1);
    const bool is_time = layout_.slots[column] == CsvLayout::kTime;
    if (is_time && field.find(':') != std::string::npos) {
      const std::optional<std::int64_t> date = recordings::date_nanoseconds(field);
      if (date && !first_date_) first_date_ = date;
      if (date) return 1e-9 * static_cast<double>(*date - *first_date_);
    }
    double value = 0.0;
    if ((!is_time || !is_missing_value(field)) && csv_number(std::move(field), layout_.separator, &value)) return value;
    p_ = first;
    fail_text(column);
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
                            " fields, expected ", layout_.slots.size(), csv_fields(line_, layout_.separator).size() == 2 * layout_.slots.size() ? ": decimal commas between commas? Write decimal points, or semicolons between the columns." : "."));
  }

  std::string where() const { return text(lines_.path(), ":", lines_.number()); }

  const CsvLayout& layout_;
  const CsvLines& lines_;
  std::optional<std::int64_t>& first_date_;
  std::string_view line_;
  const char* p_ = nullptr;
  const char* end_ = nullptr;
};

// rows with equal times and different values >= kMostEqual: the times were rounded too coarsely.
constexpr long kMostEqual = 200;
// The same for a file that ends earlier: > kFewEqual such rows, and more than kDistinct rows for each distinct
// time.
constexpr long kFewEqual = 10, kDistinct = 20;
// step of a position <= kSteady * the previous step + kSmallStep [rad, m]: the motion continues.
constexpr double kSteady = 5.0, kSmallStep = 2e-3;
// If a time, multiplied by a power of 1000, continues the previous times within kSoon steps, and these span
// more than kLater steps, the unit of the clock has changed.
constexpr double kSoon = 10.0, kLater = 100.0;
constexpr int kFirstRows = 4096;  // initial capacity of a piece; it doubles, as files may end early

}  // namespace

namespace recordings {
namespace {

class CsvRows : public RowSource {
 public:
  CsvRows(CsvLines text, const RecordingOptions& wanted, RowClock of_rows)
      : options_(wanted), clock_(of_rows), lines_(std::move(text)) {
    read_layout();
    row_.assign(static_cast<std::size_t>(layout_.slot_count()), kGap);
    set_scales();
  }

  int joints() const override { return layout_.joints; }

  Recording next(int rows) override {
    Recording piece;
    piece.source = lines_.path();
    int space = std::min(rows, kFirstRows);
    reserve(space, piece);
    int count = 0;
    while (count < rows && next_row()) {
      if (count == space) reserve(space = space > rows / 2 ? rows : 2 * space, piece);
      piece.time[count] = row_[CsvLayout::kTime];
      for (std::size_t s = 0; s < layout_.has_signal.size(); ++s) {
        if (!layout_.has_signal[s]) continue;
        MatrixXd& values = piece.*kRecordingSignals[s].values;
        const double* from = &row_[layout_.slot(static_cast<int>(s), 0)];
        for (int joint = 0; joint < layout_.joints; ++joint) values(count, joint) = from[joint];
      }
      ++count;
    }
    if (count < rows && equal_ > kFewEqual && kDistinct * (timed_ - equal_) < timed_)
      refuse_time(time_, text("so do ", equal_, " of ", timed_, " rows with other values: the times have lost their digits, and ", kCountRows));
    if (is_current_unit(unit_of(options_.signals, "tau", 0)) && piece.tau.size() > 0) {
      piece.current = std::move(piece.tau);
      piece.tau.resize(0, 0);
    }
    return count == space ? piece : rows_of(piece, 0, count);
  }

  RecordingFacts facts() const override {
    RecordingFacts facts;
    facts.format = "CSV";
    const bool named = options_.signals.joints.size() == static_cast<std::size_t>(layout_.joints);
    for (int joint = 0; joint < layout_.joints; ++joint)
      facts.joints.push_back(named ? options_.signals.joints[joint].name : std::to_string(joint + 1));
    if (repeated_ > 0)
      facts.remarks.push_back(text(repeated_, repeated_ == 1 ? " row repeats" : " rows repeat", " the time stamp before and ",
                                   repeated_ == 1 ? "is" : "are", " left out."));
    facts.remarks.insert(facts.remarks.end(), remarks_.begin(), remarks_.end());
    if (first_date_) facts.start = 1e-9 * static_cast<double>(*first_date_);
    if (options_.rate > 0.0 && layout_.has_time && !counted_from_)
      facts.remarks.push_back("the times of column t grow and are used; --rate is for files without them.");
    return facts;
  }

 private:
  void read_layout() {
    std::string_view line;
    require(lines_.next(&line), lines_.path(), ": found no row, expected a header and numbers.");
    std::string where = text(lines_.path(), ":", lines_.number());
    const std::string comment = lines_.last_comment();
    bool numbers = is_row_of_numbers(line);
    if (!options_.columns.empty()) {
      if (!numbers) {  // a header, over which options.columns takes precedence
        require(lines_.next(&line), where, ": found a header without rows, expected numbers below it.");
        where = text(lines_.path(), ":", lines_.number());
        numbers = is_row_of_numbers(line);
        require(numbers, where, ": found text in the second line, too, expected numbers.");
      }
      layout_ = layout_from_columns(options_.columns, line, where);
    } else if (!numbers) {
      layout_ = layout_from_header(line, where);
      header_.assign(line);
    } else {
      const char separator = csv_separator(line);
      require(comment.find("q1") != std::string::npos && csv_fields(comment, separator).size() == csv_fields(line, separator).size(), where,
              ": found numbers, expected a header; the first line is numbers, so name them with --columns and --rate.");
      layout_ = layout_from_header(comment, where);
      layout_.separator = separator;
    }
    const bool has_word = std::find(layout_.names.begin(), layout_.names.end(), "time") != layout_.names.end();
    require(layout_.has_time || options_.rate > 0.0, where, ": found no column t",
            has_word ? " (but 'time')" : "", ", expected one, or --rate.");
    if (numbers) first_line_.assign(line);
  }

  // Sets the scales from the units of the file to SI, for every slot of a row.
  void set_scales() {
    scales_.assign(row_.size(), {});
    const auto unit = options_.signals.units.find("t");
    if (unit != options_.signals.units.end())
      scales_[CsvLayout::kTime].factor = unit_factor("t", unit->second).value_or(1.0);
    for (std::size_t s = 0; s < layout_.has_signal.size(); ++s) {
      for (int joint = 0; joint < layout_.joints; ++joint)
        scales_[static_cast<std::size_t>(layout_.slot(static_cast<int>(s), joint))] = scale_for(options_.signals, kRecordingSignals[s].name, joint + 1);
    }
    if (std::all_of(scales_.begin(), scales_.end(), [](const UnitScale& scale) { return scale.changes_nothing(); })) scales_.clear();
  }

  void reserve(int rows, Recording& recording) const {
    recording.time.conservativeResize(rows);
    for (std::size_t s = 0; s < layout_.has_signal.size(); ++s) {
      MatrixXd& values = recording.*kRecordingSignals[s].values;
      if (layout_.has_signal[s] || s == 0) values.conservativeResize(rows, layout_.joints);
    }
  }

  // Reads the next line into the row. False at the end of the file.
  bool read_line() {
    std::string_view line = first_line_;
    if (line.empty() && !lines_.next(&line)) return false;
    if (!header_.empty() && line == header_)
      throw InvalidInput(text(lines_.path(), ":", lines_.number(), ": found the header again, expected numbers; a second recording begins here: ",
                              "--rows 0:", row_number_, " reads what is before it, --rows ", row_number_ + 1, ": the rest."));
    RowParser(layout_, lines_, first_date_).parse_row(line, &row_);
    for (std::size_t k = 0; k < scales_.size(); ++k) row_[k] = scales_[k](row_[k]);
    first_line_.clear();
    return true;
  }

  bool skip_line() {
    std::string_view line;
    return !std::exchange(first_line_, {}).empty() || lines_.next(&line);
  }

  // Reads the next row into `row_`. False at the end of the file.
  bool next_row() {
    const long last = !options_.row_count ? std::numeric_limits<long>::max() : options_.first_row + *options_.row_count;
    if (gaps_left_ == 0 && !held_row_.empty()) {
      row_.swap(held_row_);
      held_row_.clear();
    } else if (gaps_left_ == 0 && !read_timed_row(last)) {
      return false;
    }
    if (row_number_ - 1 - gaps_left_ >= last) return false;
    if (gaps_left_ == 0) return true;
    std::fill(row_.begin(), row_.end(), kGap);
    row_[CsvLayout::kTime] = time_ - step_ * static_cast<double>(gaps_left_);
    --gaps_left_;
    return true;
  }

  // Reads on until the next row with a time.
  bool read_timed_row(long last) {
    for (; row_number_ < options_.first_row; ++row_number_) {
      if (!skip_line()) return false;
    }
    for (bool fresh = false; !fresh; ++row_number_) {
      if (row_number_ >= last || !read_line()) return false;
      fresh = true;
      if (!layout_.has_time) {
        row_[CsvLayout::kTime] = static_cast<double>(row_number_) / options_.rate;
      } else if (std::isfinite(row_[CsvLayout::kTime])) {
        fresh = accept_time();
      } else if (!hold_gaps()) {
        return false;
      }
    }
    return true;
  }

  // Called at a row without a time; reads on until the next row with one. False if there is none.
  bool hold_gaps() {
    const double last_time = time_;
    for (double t = row_[CsvLayout::kTime]; !std::isfinite(t) || t == last_time; t = row_[CsvLayout::kTime]) {
      const bool empty = std::all_of(row_.begin() + 1, row_.end(), [](double value) { return std::isnan(value); });
      require(empty || t == last_time, lines_.path(), ":", lines_.number(), ": found ",
              std::isnan(t) ? "no time" : "infinite time", " in a row with numbers, expected a time in seconds.");
      ++(t == last_time ? repeated_ : gaps_left_);
      ++row_number_;
      if (!read_line()) return gaps_left_ = 0, false;
    }
    accept_time();
    // Rows at the start or end are dropped, because their time cannot be interpolated.
    if (std::isnan(last_time)) return gaps_left_ = 0, true;
    step_ = (time_ - last_time) / static_cast<double>(gaps_left_ + 1);
    held_row_ = row_;
    return true;
  }

  // Checks that the row's time increases where it has to. False if the row repeats the previous one.
  bool accept_time() {
    double& t = row_[CsvLayout::kTime];
    ++timed_;
    if (counted_from_) {
      t = time_ = counted_time_ + static_cast<double>(row_number_ - *counted_from_ + 1) / options_.rate;
      return true;
    }
    follow_unit(t);
    t = rescaled_ * t + moved_on_;
    if (std::isnan(first_time_)) first_time_ = t;
    if (t == time_ && (clock_ == RowClock::kMayBeSetBack || before_.size() != row_.size() || repeats_row_before())) {
      ++repeated_;
      return false;
    }
    if (t <= time_ && clock_ == RowClock::kRises) t = risen_time(t);
    if (t > time_) equal_run_ = 0;
    if (t > time_) step_ = t - time_;
    time_ = t;
    if (clock_ == RowClock::kRises) {
      second_before_.swap(before_);
      before_ = row_;
    }
    return true;
  }

  // The time of a row whose clock does not rise: counted by --rate, shifted after a clock was set back, or
  // unchanged. Throws if none is allowed.
  double risen_time(double t) {
    if (options_.rate > 0.0) {
      start_counting_rows();
      return time_ + 1.0 / options_.rate;
    }
    if (t < time_) {
      handle_backward_time(t);
      return time_ + step_;
    }
    ++equal_;
    if (++equal_run_ >= kMostEqual)
      refuse_time(t, text("so do ", equal_run_, " rows with other values: the times have lost their digits, and ", kCountRows));
    return t;
  }

  bool repeats_row_before() const {
    return std::equal(row_.begin() + 1, row_.end(), before_.begin() + 1, [](double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); });
  }

  [[noreturn]] void refuse_time(double found, const std::string& why) const {
    const auto column = std::find(layout_.slots.begin(), layout_.slots.end(), CsvLayout::kTime) - layout_.slots.begin();
    throw InvalidInput(fmt::format("{}:{}:{}: found time {:.15g} s after {:.15g} s, expected it to grow; {}", lines_.path(), lines_.number(), column + 1,
                                   found, time_, why));
  }

  void start_counting_rows() {
    counted_from_ = row_number_;
    counted_time_ = time_;
    remarks_.push_back(text("from row ", row_number_, " on the times do not grow: the rows are counted at ", options_.rate, " Hz, as --rate says."));
  }

  bool motion_continues() const {
    bool moves_on = second_before_.size() == row_.size() && !options_.signals.as_recorded;
    for (int joint = 0; moves_on && joint < layout_.joints; ++joint) {
      const auto at = static_cast<std::size_t>(layout_.slot(0, joint));
      moves_on = std::abs(row_[at] - before_[at]) <= kSteady * std::abs(before_[at] - second_before_[at]) + kSmallStep;
    }
    return moves_on;
  }

  // Times after a clock was set back are shifted, if the arm's motion continues. A clock that starts anew at
  // another position begins another recording, which is an error.
  void handle_backward_time(double found) {
    const bool moves_on = found > first_time_ && motion_continues();
    if (!moves_on && row_number_ < 2)
      refuse_time(found, text("time runs back: sort the rows by it where they are out of order; where they are not, ", kCountRows));
    if (!moves_on)
      refuse_time(found, text("a second recording begins at row ", row_number_, ": --rows 0:", row_number_,
                              " reads what is before it, --rows ", row_number_, ": the rest, and ", kCountRows));
    remarks_.push_back(text("the clock steps back by ", time_ + step_ - found, " s at row ", row_number_,
                            " while the arm moves on: the times behind it are moved on (--as-recorded refuses them)."));
    moved_on_ += time_ + step_ - found;
  }

  // Rescales the times if the unit of the clock changes while the motion continues.
  void follow_unit(double t) {
    const auto goes_on = [this](double next) { return next > time_ && next < time_ + kSoon * step_; };
    if (!(time_ - first_time_ > kLater * step_) || goes_on(rescaled_ * t + moved_on_) || !motion_continues()) return;
    for (const double factor : {1e-3, 1e3, 1e-6, 1e6, 1e-9, 1e9}) {
      if (!goes_on(factor * rescaled_ * t + moved_on_)) continue;
      rescaled_ *= factor;
      remarks_.push_back(fmt::format("from row {} on the times are in another unit: {} by {:.0f} they go on where those before end "
                                     "(--as-recorded keeps them).", row_number_, factor < 1.0 ? "divided" : "multiplied", std::max(factor, 1.0 / factor)));
      return;
    }
  }

  RecordingOptions options_;
  RowClock clock_;
  CsvLines lines_;
  CsvLayout layout_;
  std::string header_;              // line with the names of the columns, or empty
  std::string first_line_;          // first row of numbers, if it was read in advance
  std::vector<double> row_;         // current row; row_[0] is t
  std::vector<UnitScale> scales_;   // scale to SI for each slot; empty: nothing changes
  long row_number_ = 0;             // number of the next row in the file, from 0
  long gaps_left_ = 0;              // rows without a time that are still to be returned before held_row_
  std::vector<double> held_row_;
  std::vector<double> before_, second_before_;  // the last two rows with a time
  long timed_ = 0, repeated_ = 0;      // rows with a time; those that were dropped because they repeat the row before
  long equal_ = 0, equal_run_ = 0;     // rows with the time of the previous row: all, and in the last run
  double time_ = kGap, step_ = 0.0;    // [s] time of the last row with one, and the step to it
  double first_time_ = kGap;
  double moved_on_ = 0.0;              // [s] added to times after a clock was set back
  double rescaled_ = 1.0;              // factor of the times after their unit has changed
  std::optional<long> counted_from_;   // number of the first row whose time is counted by --rate
  double counted_time_ = 0.0;          // [s] time of the row before it
  std::optional<std::int64_t> first_date_;  // [ns] date of the first row that has one
  std::vector<std::string> remarks_;
};

}  // namespace

std::unique_ptr<RowSource> csv_rows(CsvLines lines, const RecordingOptions& options, RowClock clock) {
  return std::make_unique<CsvRows>(std::move(lines), options, clock);
}

}  // namespace recordings
}  // namespace veridyn
