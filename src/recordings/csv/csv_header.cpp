#include "recordings/csv/csv_header.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <utility>

#include "files/words.hpp"
#include "recordings/csv/csv_layout.hpp"
#include "recordings/signals/joint_fields.hpp"

namespace veridyn::recordings {
namespace {

constexpr int kPreamble = 30;  // largest number of lines before a header
constexpr int kRecordedSignals = static_cast<int>(std::size(kRecordingSignals));

bool is_position(const std::string& name) {
  return field_of(split_topic(plain_name(name)).path).signal == 0;
}

bool is_unit_word(const std::string& word) {
  static const std::set<std::string> kUnits = {"s", "ms", "us", "ns", "rad", "deg", "m", "mm", "rad/s", "deg/s", "m/s",
                                               "nm", "n", "a", "ma", "mnm", "ncm", "-", ""};
  return kUnits.count(to_lower(bare_unit(word))) > 0;
}

// Reads the line below the names: units, or the first row of numbers.
void read_below(std::string_view line, CsvHeader* header) {
  std::vector<std::string> fields = csv_fields(line, header->separator);
  const bool units = fields.size() == header->names.size() && std::all_of(fields.begin(), fields.end(), is_unit_word) &&
                     std::any_of(fields.begin(), fields.end(), [](const std::string& field) { return !field.empty(); });
  if (units) {
    header->units = std::move(fields);
  } else {
    header->first_row = line;
  }
}

}  // namespace

TopicColumn split_topic(const std::string& name) {
  if (name.rfind('/', 0) != 0) return {"", name};
  const std::size_t last = name.rfind('/');
  const std::size_t before = last > 0 ? name.rfind('/', last - 1) : std::string::npos;
  const RawField field = field_of(name.substr(before == std::string::npos ? 0 : before + 1));
  const bool of_joint = field.signal >= 0 && before != std::string::npos && before > 0 &&
                        name.find('[', last) == std::string::npos;
  // `/pan/position`: a topic with one number, for one joint.
  const bool alone = before == 0 && field.signal >= 0 && name.find_first_of("[0123456789", last) == std::string::npos &&
                     field_of(name.substr(last + 1)).signal >= 0;
  if (alone) return {"", name.substr(1)};
  const std::size_t cut = of_joint ? before : last;
  if (cut == 0) return {"", name};
  return {name.substr(0, cut), name.substr(cut + 1)};
}

std::string plain_name(const std::string& name) {
  return starts_with(name, "field.") ? name.substr(6) : name;
}

std::string time_name(const RecordingOptions& options) {
  const auto time = options.signals.map.find("t");
  return time == options.signals.map.end() ? std::string() : time->second;
}

std::string bare_unit(std::string unit) {
  static const std::map<std::string, std::string> kSpellings = {{"°", "deg"}, {"°/s", "deg/s"}, {"degs", "deg/s"},
                                                                {"nm", "Nm"}, {"mnm", "mNm"},   {"ma", "mA"}};
  const auto is_sign = [](char c) { return std::string_view("[]() *").find(c) != std::string_view::npos; };
  unit.erase(std::remove_if(unit.begin(), unit.end(), is_sign), unit.end());
  const auto known = kSpellings.find(unit);
  return known == kSpellings.end() ? unit : known->second;
}

std::optional<CsvHeader> find_csv_header(CsvLines& lines, const RecordingOptions& options) {
  std::string_view line;
  for (int k = 0; k < kPreamble && lines.next(&line); ++k) {
    CsvHeader header;
    header.separator = csv_separator(line);
    header.names = csv_fields(line, header.separator);
    const std::size_t columns = header.names.size();
    const bool numbers = is_row_of_numbers(line);
    if (numbers) header.names = csv_fields(lines.last_comment(), header.separator);
    if (numbers && (lines.last_comment().empty() || header.names.size() != columns)) return std::nullopt;
    header.time = time_columns(header.names, time_name(options));
    header.positions = static_cast<int>(std::count_if(header.names.begin(), header.names.end(), is_position));
    header.line = lines.number();
    if (columns < 2 || (!header.time.recorded && header.positions == 0)) continue;
    if (numbers) {
      header.first_row = line;
    } else if (lines.next(&line)) {
      read_below(line, &header);
    }
    return header;
  }
  return std::nullopt;
}

bool is_plain(const CsvHeader& header) {
  if (!header.units.empty()) return false;
  const auto has = [&header](const char* name) {
    return std::find(header.names.begin(), header.names.end(), name) != header.names.end();
  };
  if (!has("q1") || (!has("t") && header.time.recorded)) return false;
  // A signal that occurs under two names, such as qd1 and q1, has to be distinguished by its full name.
  int own[kRecordedSignals] = {};
  int other[kRecordedSignals] = {};
  for (const std::string& name : header.names) {
    const RawField field = field_of(name);
    if (field.signal < 0 || field.joint.find_first_not_of("0123456789") != std::string::npos) continue;
    ++(name == kRecordingSignals[field.signal].name + field.joint ? own : other)[field.signal];
  }
  for (int s = 1; s < kRecordedSignals; ++s) {
    if (own[s] == 0 && other[s] == own[0]) return false;
  }
  return true;
}

}  // namespace veridyn::recordings
