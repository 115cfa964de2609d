#include "recordings/csv/csv_table.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <set>

#include "math/median.hpp"
#include "recordings/csv/csv_header.hpp"
#include "recordings/csv/time_column.hpp"
#include "recordings/signals/joint_fields.hpp"
#include "recordings/signals/units.hpp"
#include "veridyn/math/require.hpp"
#include "recordings/csv/csv_layout.hpp"

namespace veridyn::recordings {
namespace {

constexpr double kGap = std::numeric_limits<double>::quiet_NaN();
constexpr int kPreamble = 30;        // largest number of lines before a header
constexpr std::size_t kDistinct = 20;  // rows for each distinct time, above which the times have lost their digits
constexpr std::size_t kProbe = 400;  // rows used to guess the unit of the time

// Destination of a column: its stream and its field there; stream -1: the column is dropped.
struct Place {
  int stream = -1;
  std::size_t field = 0;
};

class Table {
 public:
  Table(CsvLines& lines, const RecordingOptions& options) : lines_(lines), options_(options) {
    const auto time = options.signals.map.find("t");
    if (time != options.signals.map.end()) time_name_ = time->second;
  }

  // Finds the header. False if there is none.
  bool find_header() {
    std::string_view line;
    for (int k = 0; k < kPreamble && lines_.next(&line); ++k) {
      CsvHeader header = parse_csv_header(line, time_name_);
      const bool numbers = is_row_of_numbers(line);
      const std::string comment = lines_.last_comment();
      if (numbers && !comment.empty()) {  // the last comment may be the header
        CsvHeader above = parse_csv_header(comment, time_name_);
        above.separator = header.separator;
        above.names = csv_fields(comment, header.separator);
        if (above.names.size() != header.names.size()) return false;
        above.time = time_columns(above.names, time_name_);
        header = std::move(above);
        first_row_ = line;
      } else if (numbers) {
        return false;
      }
      // Other lines may precede the header, which is recognised by a clock or by positions of joints.
      if (header.names.size() > 1 && (header.time.recorded || header.positions > 0)) {
        header_ = std::move(header);
        header_line_ = lines_.number();
        return true;
      }
    }
    return false;
  }

  const CsvHeader& header() const { return header_; }

  RawRecording read() {
    require(find_header(), lines_.path(), ": found no header with names of joints, expected one.");
    if (!time_name_.empty())
      require(std::find(header_.names.begin(), header_.names.end(), time_name_) !=
                  header_.names.end(),
              lines_.path(), ": --map t=", time_name_, ": found no column ", time_name_,
              ", expected one.");
    require(header_.time.recorded || options_.rate > 0.0, lines_.path(), ":", header_line_,
            ": found no column of time, expected one (time, timestamp, t), --map t=NAME or --rate.");
    read_units_line();
    place_columns();
    read_rows();
    set_times();
    return std::move(raw_);
  }

 private:
  void read_units_line() {
    if (!first_row_.empty()) return;
    std::string_view line;
    if (!lines_.next(&line)) return;
    std::vector<std::string> fields = csv_fields(line, header_.separator);
    const bool units = fields.size() == header_.names.size() &&
                       std::all_of(fields.begin(), fields.end(), is_unit_word) &&
                       std::any_of(fields.begin(), fields.end(), [](const auto& f) { return !f.empty(); });
    if (units) {
      header_.units = std::move(fields);
    } else {
      first_row_ = line;
    }
  }

  bool is_time(std::size_t column) const {
    const auto c = static_cast<int>(column);
    return c == header_.time.recorded || c == header_.time.nanoseconds || c == header_.time.stamped;
  }

  void place_columns() {
    raw_.format = "CSV";
    std::map<std::string, int> stream_of_topic;
    places_.resize(header_.names.size());
    factors_.assign(header_.names.size(), 1.0);
    std::set<std::string> told;
    for (std::size_t k = 0; k < header_.names.size(); ++k) {
      if (is_time(k)) continue;
      const std::string name = plain_name(header_.names[k]);
      if (name.rfind("name", 0) == 0 && name.size() > 4 &&
          name.find_first_not_of("0123456789", 4) == std::string::npos) {
        names_column_[std::stoi(name.substr(4, 4))] = static_cast<int>(k);
        continue;
      }
      const TopicColumn split = split_topic(name);
      const auto [at, fresh] =
          stream_of_topic.try_emplace(split.topic, static_cast<int>(raw_.streams.size()));
      if (fresh) {
        raw_.streams.emplace_back();
        raw_.streams.back().topic = split.topic;
      }
      RawStream& stream = raw_.streams[at->second];
      RawField field = field_of(split.path);
      if (split.topic.empty()) field.path = header_.names[k];
      factors_[k] = factor_of(k, field, &told);
      places_[k] = {at->second, stream.fields.size()};
      stream.fields.push_back(std::move(field));
    }
    if (!told.empty()) {
      std::string list;
      for (const std::string& one : told) list += (list.empty() ? "" : ", ") + one;
      raw_.remarks.push_back("columns say their units and are turned into SI: " + list + ".");
    }
  }

  // Factor to SI, from the unit in the column's name or in the second line.
  double factor_of(std::size_t column, const RawField& field, std::set<std::string>* told) const {
    if (field.signal < 0) return 1.0;
    const std::string unit =
        bare_unit(header_.units.empty() ? unit_in(header_.names[column]) : header_.units[column]);
    const std::string signal = kRecordingSignals[field.signal].name;
    std::string known = unit;
    if (unit == "nm") known = "Nm";
    if (unit == "mnm") known = "mNm";
    if (unit == "ma") known = "mA";
    if (unit == "degs") known = "deg/s";
    const auto factor = unit_factor(signal, known);
    if (!factor || *factor == 1.0) return 1.0;
    told->insert(signal + " in " + known);
    return *factor;
  }

  void read_rows() {
    std::string_view line;
    std::vector<std::vector<double>> rows(raw_.streams.size());
    for (std::size_t s = 0; s < rows.size(); ++s) rows[s].resize(raw_.streams[s].fields.size());
    long number = 0;
    bool held = !first_row_.empty();
    while (true) {
      if (held) {
        line = first_row_;
        held = false;
      } else if (!lines_.next(&line)) {
        break;
      }
      std::vector<std::string> fields = csv_fields(line, header_.separator);
      if (fields.size() != header_.names.size()) {
        if (fields.size() < header_.names.size() && lines_.at_end()) {
          raw_.remarks.emplace_back("the last row is cut and left out.");
          break;
        }
        throw InvalidInput(text(lines_.path(), ":", lines_.number(), ": found ", fields.size(),
                                " fields, expected ", header_.names.size(), "."));
      }
      read_joint_names(fields);
      append_row(&fields, number++, &rows);
    }
    if (skipped_ > 0)
      raw_.remarks.push_back(text(skipped_, skipped_ == 1 ? " row has" : " rows have",
                                  " no time and ", skipped_ == 1 ? "is" : "are", " left out."));
  }

  // Reads the names of the joints from their own columns.
  void read_joint_names(const std::vector<std::string>& fields) {
    if (names_column_.empty()) return;
    for (RawStream& stream : raw_.streams) {
      for (RawField& field : stream.fields) {
        if (field.signal < 0 || field.joint.size() > 4 ||
            field.joint.find_first_not_of("0123456789") != std::string::npos)
          continue;
        const auto column = names_column_.find(std::stoi(field.joint));
        if (column != names_column_.end()) field.joint = fields[column->second];
      }
    }
    names_column_.clear();
  }

  void append_row(std::vector<std::string>* fields, long number,
                std::vector<std::vector<double>>* rows) {
    std::vector<char> any(raw_.streams.size(), 0);
    for (std::size_t k = 0; k < fields->size(); ++k) {
      const Place place = places_[k];
      if (place.stream < 0) continue;
      const auto s = static_cast<std::size_t>(place.stream);
      double value = kGap;
      if (!(*fields)[k].empty() && !csv_number((*fields)[k], header_.separator, &value)) {
        const RawField& field = raw_.streams[s].fields[place.field];
        require(field.signal < 0, lines_.path(), ":", lines_.number(), ":", k + 1, ": found '",
                (*fields)[k].substr(0, 40), "' in column ", header_.names[k],
                ", expected a number.");
        value = kGap;
      }
      if (!std::isnan(value)) any[s] = 1;
      (*rows)[s][place.field] = value * factors_[k];
    }
    std::string time;
    if (header_.time.recorded) {
      time = (*fields)[*header_.time.recorded];
      if (header_.separator != ',') std::replace(time.begin(), time.end(), ',', '.');
      if (time.empty() || time == "nan" || time == "NaN") {
        ++skipped_;
        return;
      }
      require(nanoseconds_of(time, 1).has_value(), lines_.path(), ":", lines_.number(), ":",
              *header_.time.recorded + 1, ": found '", time.substr(0, 40), "' in column ",
              header_.names[*header_.time.recorded],
              ", expected a time.");
    }
    std::int64_t stamp = 0;
    if (header_.time.stamped)
      stamp = nanoseconds_of((*fields)[*header_.time.stamped], 1).value_or(0);
    if (std::abs(stamp) > kLargestTime) stamp = 0;
    std::int64_t fraction = 0;
    if (header_.time.nanoseconds)
      fraction = nanoseconds_of((*fields)[*header_.time.nanoseconds], 1).value_or(0);
    const std::size_t at = times_.size();
    times_.push_back(std::move(time));
    fractions_.push_back(fraction);
    numbers_.push_back(number);
    const bool many = raw_.streams.size() > 1;
    for (std::size_t s = 0; s < raw_.streams.size(); ++s) {
      if (many && any[s] == 0) continue;
      RawStream& stream = raw_.streams[s];
      // The row's number; replaced by its time at the end.
      stream.recorded.push_back(static_cast<std::int64_t>(at));
      if (header_.time.stamped) stream.stamped.push_back(stamp);
      stream.values.insert(stream.values.end(), (*rows)[s].begin(), (*rows)[s].end());
    }
  }

  // Length of one unit of the clock [ns].
  std::int64_t time_unit() {
    const auto given = options_.signals.units.find("t");
    if (given != options_.signals.units.end())
      return std::llround(unit_factor("t", given->second).value_or(1.0) * 1e9);
    if (header_.time.unit != 0) return header_.time.unit;
    if (!header_.units.empty()) {
      const std::string unit = bare_unit(header_.units[*header_.time.recorded]);
      if (const auto factor = unit_factor("t", unit)) return std::llround(*factor * 1e9);
    }
    if (date_nanoseconds(times_.front())) return 1;
    const std::string in_name = unit_in(header_.names[*header_.time.recorded]);
    if (const auto factor = unit_factor("t", in_name)) return std::llround(*factor * 1e9);
    std::vector<double> steps;
    bool whole = true;
    for (std::size_t k = 0; k < times_.size() && k < kProbe; ++k) {
      whole = whole && times_[k].find_first_of(".eE") == std::string::npos;
      if (k > 0) steps.push_back(std::stod(times_[k]) - std::stod(times_[k - 1]));
    }
    if (steps.empty()) return 1000000000;
    const std::int64_t unit =
        likely_time_unit(std::stod(times_.front()), median(std::move(steps)), whole);
    if (unit != 1000000000)
      raw_.remarks.push_back(text("times are taken for ",
                                  unit == 1      ? "nanoseconds"
                                  : unit == 1000 ? "microseconds"
                                                 : "milliseconds",
                                  " by their size (--units t=s says otherwise)."));
    return unit;
  }

  void set_times() {
    if (times_.empty()) return;
    bool clock = header_.time.recorded.has_value();
    const std::int64_t unit = clock ? time_unit() : 0;
    std::size_t standing = 0;
    for (std::size_t k = 1; clock && k < times_.size(); ++k) standing += times_[k] == times_[k - 1] && fractions_[k] == fractions_[k - 1];
    if (kDistinct * (times_.size() - standing) < times_.size() && options_.rate <= 0.0)
      throw InvalidInput(text(lines_.path(), ":", header_line_ + 1, ": found ", standing, " rows of ", times_.size(), " with the time of the row before (",
                              times_.back(), "), expected times that grow; they have lost their digits: ", kCountRows));
    if (standing > 0 && options_.rate > 0.0) {
      clock = false;
      raw_.remarks.push_back(text("times do not grow: the rows are counted at ", options_.rate, " Hz, as --rate says."));
    }
    for (RawStream& stream : raw_.streams) {
      for (std::int64_t& time : stream.recorded) {
        const auto row = static_cast<std::size_t>(time);
        if (!clock) {
          const double t = static_cast<double>(numbers_[row]) * 1e9 / options_.rate;
          require(t < static_cast<double>(kLargestTime), lines_.path(), ": found ", numbers_[row],
                  " rows, expected less than 95 years of them at --rate ", options_.rate, ".");
          time = std::llround(t);
          continue;
        }
        const std::int64_t parsed = nanoseconds_of(times_[row], unit).value_or(kLargestTime);
        require(std::abs(parsed) < kLargestTime && std::abs(fractions_[row]) < kLargestTime - std::abs(parsed),
                lines_.path(), ": found time ", times_[row], ", expected one within 95 years.");
        time = parsed + fractions_[row];
      }
    }
  }

  CsvLines& lines_;
  const RecordingOptions& options_;
  std::string time_name_;
  CsvHeader header_;
  long header_line_ = 0;
  std::string first_row_;
  RawRecording raw_;
  std::vector<Place> places_;
  std::vector<double> factors_;
  std::map<int, int> names_column_;
  std::vector<std::string> times_;
  std::vector<std::int64_t> fractions_;
  std::vector<long> numbers_;
  long skipped_ = 0;
};

}  // namespace

bool is_csv_table(CsvLines& lines, const RecordingOptions& options) {
  if (!options.columns.empty()) return false;
  Table table(lines, options);
  const bool found = table.find_header();
  lines.rewind();
  if (!found) return false;
  if (!options.signals.map.empty()) return true;
  if (is_plain(table.header())) return false;
  if (table.header().positions > 0) return true;
  // Number of columns named exactly like joints.
  std::size_t named = 0;
  for (const WantedJoint& joint : options.signals.joints) {
    for (const std::string& name : table.header().names) named += name.find(joint.name) != std::string::npos;
  }
  return named > 0 && named >= options.signals.joints.size();
}

RawRecording read_csv_table(CsvLines lines, const RecordingOptions& options) {
  return Table(lines, options).read();
}

}  // namespace veridyn::recordings
