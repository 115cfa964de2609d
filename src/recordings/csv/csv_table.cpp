#include "recordings/csv/csv_table.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "files/words.hpp"
#include "recordings/csv/csv_header.hpp"
#include "recordings/csv/csv_layout.hpp"
#include "recordings/csv/time_column.hpp"
#include "recordings/signals/joint_fields.hpp"
#include "recordings/signals/units.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::recordings {
namespace {

constexpr double kGap = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kDistinct = 20;  // rows per distinct time, above which the times were rounded too coarsely

// Destination of a column: its stream and its field there, and its factor to SI; stream -1: the column is dropped.
struct Place {
  int stream = -1;
  std::size_t field = 0;
  double factor = 1.0;
};

// The time of a row as written, as long as the unit of the clock is unknown.
struct RowTime {
  std::string time;
  std::int64_t fraction = 0;  // [ns]
  long number = 0;            // number of the row from 0
};

class Table {
 public:
  Table(CsvLines& lines, const RecordingOptions& options, CsvHeader header)
      : lines_(lines), options_(options), header_(std::move(header)) {}

  RawRecording read_table() {
    const std::string wanted = time_name(options_);
    require(wanted.empty() || std::find(header_.names.begin(), header_.names.end(), wanted) != header_.names.end(), lines_.path(), ": --map t=", wanted,
            ": found no column ", wanted, ", expected one.");
    require(header_.time.recorded || options_.rate > 0.0, lines_.path(), ":", header_.line,
            ": found no column of time, expected one (time, timestamp, t), --map t=NAME or --rate.");
    raw_.format = "CSV";
    assign_columns();
    read_rows();
    if (!rows_.empty()) set_times();
    return std::move(raw_);
  }

 private:
  bool is_time(std::size_t column) const {
    const auto c = static_cast<int>(column);
    return c == header_.time.recorded || c == header_.time.nanoseconds || c == header_.time.stamped;
  }

  void assign_columns() {
    std::map<std::string, int> stream_of_topic;
    std::set<std::string> units;
    places_.resize(header_.names.size());
    for (std::size_t k = 0; k < header_.names.size(); ++k) {
      if (is_time(k)) continue;
      const std::string name = plain_name(header_.names[k]);
      if (starts_with(name, "name") && is_number(name.substr(4))) {
        names_column_[std::stoi(name.substr(4, 4))] = k;
        continue;
      }
      const TopicColumn split = split_topic(name);
      const auto [at, fresh] = stream_of_topic.try_emplace(split.topic, static_cast<int>(raw_.streams.size()));
      if (fresh) raw_.streams.emplace_back().topic = split.topic;
      RawStream& stream = raw_.streams[at->second];
      RawField field = field_of(split.path);
      if (split.topic.empty()) field.path = header_.names[k];
      places_[k] = {at->second, stream.fields.size(), factor_of(k, field, &units)};
      stream.fields.push_back(std::move(field));
    }
    if (!units.empty())
      raw_.remarks.push_back("columns say their units and are turned into SI: " + joined({units.begin(), units.end()}) + ".");
  }

  // The unit in a column's name or in the second line.
  std::string unit_of_column(std::size_t column) const {
    return bare_unit(header_.units.empty() ? unit_in(header_.names[column]) : header_.units[column]);
  }

  // Factor to SI; adds units other than SI to the list.
  double factor_of(std::size_t column, const RawField& field, std::set<std::string>* units) const {
    if (field.signal < 0) return 1.0;
    const std::string unit = unit_of_column(column), signal = kRecordingSignals[field.signal].name;
    const double factor = unit_factor(signal, unit).value_or(1.0);
    if (factor != 1.0) units->insert(signal + " in " + unit);
    return factor;
  }

  void read_rows() {
    std::string_view line = header_.first_row;
    for (long number = 0; !line.empty() || lines_.next(&line); ++number, line = {}) {
      const std::vector<std::string> fields = csv_fields(line, header_.separator);
      if (fields == header_.names || (fields == header_.units && number > 0)) {
        ++repeated_;
        --number;
        below_header_ = true;
        continue;
      }
      if (fields.size() < header_.names.size() && lines_.at_end()) {
        raw_.remarks.emplace_back("the last row is cut and left out.");
        break;
      }
      require(fields.size() == header_.names.size(), lines_.path(), ":", lines_.number(), ": found ", fields.size(),
              " fields, expected ", header_.names.size(), ".");
      if (!names_column_.empty()) read_joint_names(fields);
      append_row(fields, number);
    }
    if (skipped_ > 0)
      raw_.remarks.push_back(text(skipped_, skipped_ == 1 ? " row has no time and is" : " rows have no time and are", " left out."));
    if (repeated_ > 0) raw_.remarks.push_back(text(repeated_, repeated_ == 1 ? " line repeats" : " lines repeat", " the header or its units and ", repeated_ == 1 ? "is" : "are", " left out."));
  }

  // Reads the names of the joints from their own columns, in the first row.
  void read_joint_names(const std::vector<std::string>& fields) {
    for (RawStream& stream : raw_.streams) {
      for (RawField& field : stream.fields) {
        if (field.signal < 0 || field.joint.size() > 4 || !is_number(field.joint)) continue;
        const auto column = names_column_.find(std::stoi(field.joint));
        if (column != names_column_.end()) field.joint = fields[column->second];
      }
    }
    names_column_.clear();
  }

  // The number in a field; a text counts as a gap if the column is of no signal.
  double number_in(const std::vector<std::string>& fields, std::size_t column) const {
    double value = kGap;
    const bool known = csv_number(fields[column], header_.separator, &value);
    const Place& place = places_[column];
    require(known || raw_.streams[place.stream].fields[place.field].signal < 0, lines_.path(), ":", lines_.number(), ":", column + 1, ": found '",
            fields[column].substr(0, 40), "' in column ", header_.names[column], ", expected a number.");
    return value * place.factor;
  }

  // The whole nanoseconds in a column of the clock; 0 without one.
  static std::int64_t nanoseconds_in(const std::vector<std::string>& fields, const std::optional<int>& column) {
    return column ? nanoseconds_of(fields[*column], 1).value_or(0) : 0;
  }

  // A time for comparisons, whatever its unit.
  static double moment_of(const std::string& time) {
    const std::optional<std::int64_t> date = date_nanoseconds(time);
    return date ? static_cast<double>(*date) : std::strtod(time.c_str(), nullptr);
  }

  void append_row(const std::vector<std::string>& fields, long number) {
    values_.resize(raw_.streams.size());
    for (std::vector<double>& values : values_) values.clear();
    for (std::size_t k = 0; k < fields.size(); ++k) {
      if (places_[k].stream >= 0) values_[places_[k].stream].push_back(number_in(fields, k));
    }
    RowTime row{"", nanoseconds_in(fields, header_.time.nanoseconds), number};
    if (header_.time.recorded) {
      const int column = *header_.time.recorded;
      row.time = fields[column];
      if (header_.separator != ',') std::replace(row.time.begin(), row.time.end(), ',', '.');
      if (row.time.empty() || row.time == "nan" || row.time == "NaN") {
        ++skipped_;
        return;
      }
      require(nanoseconds_of(row.time, 1).has_value(), lines_.path(), ":", lines_.number(), ":", column + 1, ": found '",
              row.time.substr(0, 40), "' in column ", header_.names[column], ", expected a time.");
      require(!below_header_ || rows_.empty() || moment_of(row.time) > moment_of(rows_.back().time), lines_.path(), ":", lines_.number(),
              ": found the header again and an earlier time, expected one recording: a second one begins here, split the file.");
      below_header_ = false;
    }
    std::int64_t stamp = nanoseconds_in(fields, header_.time.stamped);
    if (std::abs(stamp) > kLargestTime) stamp = 0;
    for (std::size_t s = 0; s < values_.size(); ++s) {
      const bool none = std::all_of(values_[s].begin(), values_[s].end(), [](double v) { return std::isnan(v); });
      if (none && values_.size() > 1) continue;
      RawStream& stream = raw_.streams[s];
      stream.recorded.push_back(static_cast<std::int64_t>(rows_.size()));  // replaced by the time of this row at the end
      if (header_.time.stamped) stream.stamped.push_back(stamp);
      stream.values.insert(stream.values.end(), values_[s].begin(), values_[s].end());
    }
    rows_.push_back(std::move(row));
  }

  // Length of one unit of the clock [ns].
  std::int64_t clock_unit() {
    std::int64_t named = header_.time.unit;
    for (const std::string& unit : {unit_of_column(*header_.time.recorded), unit_in(header_.names[*header_.time.recorded])}) {
      if (named == 0) named = std::llround(unit_factor("t", unit).value_or(0.0) * 1e9);
    }
    if (named == 0 && date_nanoseconds(rows_.front().time)) named = 1;
    std::vector<double> first;
    bool whole = true;
    for (std::size_t k = 0; k < rows_.size() && k < kTimesForUnit; ++k) {
      whole = whole && rows_[k].time.find_first_of(".eE") == std::string::npos;
      first.push_back(std::strtod(rows_[k].time.c_str(), nullptr));
    }
    return time_unit(options_.signals, named, first, whole, &raw_.remarks);
  }

  // True if the rows have to be counted, because there is no clock, or its times do not increase.
  bool counts_rows() {
    if (!header_.time.recorded) return true;
    std::size_t standing = 0;
    for (std::size_t k = 1; k < rows_.size(); ++k) standing += rows_[k].time == rows_[k - 1].time && rows_[k].fraction == rows_[k - 1].fraction;
    require(kDistinct * (rows_.size() - standing) >= rows_.size() || options_.rate > 0.0, lines_.path(), ":", header_.line + 1, ": found ", standing,
            " rows of ", rows_.size(), " with the time of the row before (", rows_.back().time,
            "), expected times that grow; they have lost their digits: ", kCountRows);
    if (standing == 0 || options_.rate <= 0.0) return false;
    raw_.remarks.push_back(text("times do not grow: the rows are counted at ", options_.rate, " Hz, as --rate says."));
    return true;
  }

  void set_times() {
    const std::int64_t unit = header_.time.recorded ? clock_unit() : 0;
    const bool counted = counts_rows();
    for (RawStream& stream : raw_.streams) {
      for (std::int64_t& time : stream.recorded) time = counted ? counted_time(rows_[time]) : clock_time(rows_[time], unit);
    }
  }

  std::int64_t counted_time(const RowTime& row) const {
    const double t = static_cast<double>(row.number) * 1e9 / options_.rate;
    require(t < static_cast<double>(kLargestTime), lines_.path(), ": found ", row.number,
            " rows, expected less than 95 years of them at --rate ", options_.rate, ".");
    return std::llround(t);
  }

  std::int64_t clock_time(const RowTime& row, std::int64_t unit) const {
    const std::int64_t time = nanoseconds_of(row.time, unit).value_or(kLargestTime);
    require(std::abs(time) < kLargestTime && std::abs(row.fraction) < kLargestTime - std::abs(time),
            lines_.path(), ": found time ", row.time, ", expected one within 95 years.");
    return time + row.fraction;
  }

  CsvLines& lines_;
  const RecordingOptions& options_;
  CsvHeader header_;
  RawRecording raw_;
  std::vector<Place> places_;                // destination of every column
  std::map<int, std::size_t> names_column_;  // column with the name of the joint of each number
  std::vector<RowTime> rows_;
  std::vector<std::vector<double>> values_;  // values of the present row, stream by stream
  long skipped_ = 0, repeated_ = 0;  // rows without a time; lines that repeat the header
  bool below_header_ = false;        // the line before repeats the header
};

// True for a header of a table, and not of a plain recording or of anything else.
bool is_table(const CsvHeader& header, const RecordingOptions& options) {
  if (!options.signals.map.empty()) return true;
  if (is_plain(header)) return false;
  if (header.positions > 0) return true;
  // Number of columns named exactly like joints.
  std::size_t named = 0;
  for (const WantedJoint& joint : options.signals.joints) {
    for (const std::string& name : header.names) named += name.find(joint.name) != std::string::npos;
  }
  return named > 0 && named >= options.signals.joints.size();
}

}  // namespace

std::optional<CsvHeader> table_header(CsvLines& lines, const RecordingOptions& options) {
  if (!options.columns.empty()) return std::nullopt;
  std::optional<CsvHeader> header = find_csv_header(lines, options);
  if (header && is_table(*header, options)) return header;
  lines.rewind();
  return std::nullopt;
}

RawRecording read_csv_table(CsvLines lines, CsvHeader header, const RecordingOptions& options) {
  return Table(lines, options, std::move(header)).read_table();
}

}  // namespace veridyn::recordings
