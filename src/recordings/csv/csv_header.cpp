#include "recordings/csv/csv_header.hpp"

#include <algorithm>
#include <iterator>
#include <set>

#include "recordings/csv/csv_layout.hpp"
#include "recordings/signals/joint_fields.hpp"
#include "veridyn/recordings/recording.hpp"

namespace veridyn::recordings {
namespace {

constexpr int kRecordedSignals = static_cast<int>(std::size(kRecordingSignals));

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
  return name.rfind("field.", 0) == 0 ? name.substr(6) : name;
}

CsvHeader parse_csv_header(std::string_view line, const std::string& time_name) {
  CsvHeader header;
  header.separator = csv_separator(line);
  header.names = csv_fields(line, header.separator);
  header.time = time_columns(header.names, time_name);
  for (const std::string& name : header.names) {
    if (field_of(split_topic(plain_name(name)).path).signal == 0) ++header.positions;
  }
  return header;
}

bool is_unit_word(const std::string& word) {
  static const std::set<std::string> kUnits = {
      "s",   "ms",  "us",   "ns",   "rad",  "deg",   "m",     "mm",    "rad/s", "deg/s",
      "m/s", "nm",  "n",    "n m",  "n*m",  "a",     "ma",    "mnm",   "-",     "",
      "[s]", "[rad]", "[deg]", "[nm]", "[a]", "[rad/s]", "[deg/s]", "°", "°/s", "ncm"};
  std::string lower = word;
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return kUnits.count(lower) > 0;
}

std::string bare_unit(std::string unit) {
  for (const char* sign : {"[", "]", "(", ")", " ", "*"}) {
    for (std::size_t at = unit.find(sign); at != std::string::npos; at = unit.find(sign))
      unit.erase(at, 1);
  }
  if (unit == "°") return "deg";
  if (unit == "°/s") return "deg/s";
  return unit;
}

bool is_plain(const CsvHeader& header) {
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
