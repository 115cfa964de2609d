#include "recordings/csv/csv_layout.hpp"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <map>
#include <set>

#include "model/excerpt.hpp"
#include "files/words.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr int kSignals = static_cast<int>(std::size(kRecordingSignals));

// Index into kRecordingSignals, or -1.
int signal_index(const std::string& name) {
  for (int s = 0; s < kSignals; ++s) {
    if (name == kRecordingSignals[s].name) return s;
  }
  return -1;
}

// A column name such as `dq12`: base `dq` and number 12. The number is -1 if there are no digits, and the
// signal is -1 if the base is no signal.
struct ColumnName {
  std::string base;
  int signal = -1;
  int number = -1;
};

ColumnName column_name(const std::string& name) {
  const std::size_t digits = name.find_last_not_of("0123456789") + 1;
  const std::string base = name.substr(0, digits);
  const bool numbered = digits < name.size() && name.size() - digits < 6;
  return {base, signal_index(base), numbered ? std::stoi(name.substr(digits)) : -1};
}

// The signal that a misspelt column name probably means, or -1: different case, `_` before the number,
// swapped letters, or a common word.
int likely_signal(const ColumnName& name) {
  static const std::map<std::string, const char*> kWords = {
      {"pos", "q"},    {"position", "q"}, {"angle", "q"},   {"vel", "dq"},     {"velocity", "dq"},
      {"qdot", "dq"},  {"acc", "ddq"},    {"qddot", "ddq"}, {"torque", "tau"}, {"effort", "tau"},
      {"taus", "tau"}, {"ta", "tau"},     {"tu", "tau"},    {"force", "tau"},  {"current", "i"}};
  std::string base = to_lower(name.base);
  base.erase(base.find_last_not_of("_. ") + 1);
  const auto word = kWords.find(base);
  if (word != kWords.end()) return signal_index(word->second);
  for (int s = 0; s < kSignals; ++s) {
    const std::string known = kRecordingSignals[s].name;
    if (std::is_permutation(base.begin(), base.end(), known.begin(), known.end())) return s;
  }
  return -1;
}

void suggest_missing(const CsvLayout& layout, const std::vector<ColumnName>& columns, const std::string& where) {
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const int meant = layout.slots[k] == CsvLayout::kIgnored && columns[k].number >= 0 ? likely_signal(columns[k]) : -1;
    if (meant < 0 || layout.has_signal[meant]) continue;
    throw InvalidInput(text(where, ":", k + 1, ": found column '", layout.names[k],
                            "' and no ", kRecordingSignals[meant].name, ", expected '",
                            kRecordingSignals[meant].name, std::max(columns[k].number, 1),
                            "' (rename the column if it is something else)."));
  }
}

// The first few names, for messages.
std::string first_names(const std::vector<std::string>& names) {
  std::string list;
  for (std::size_t k = 0; k < names.size() && k < 8; ++k) list += (k > 0 ? ", " : "") + excerpt(names[k]);
  return names.size() > 8 ? text(list, ", ... (", names.size(), " columns)") : list;
}

// Largest joint number of a signal; its joints must be numbered from 1 without a gap.
int joints_of(int signal, const std::vector<ColumnName>& columns, const std::string& where) {
  const std::string name = kRecordingSignals[signal].name;
  std::vector<int> numbers;
  for (const ColumnName& column : columns) {
    if (column.signal == signal && column.number >= 0) numbers.push_back(column.number);
  }
  std::sort(numbers.begin(), numbers.end());
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    const int expected = static_cast<int>(k) + 1;
    require(k == 0 || numbers[k] != numbers[k - 1], where, ": found column ", name, numbers[k],
            " twice, expected it once: rename the one that is not to be used.");
    require(numbers[0] != 0, where, ": found ", name, "0, expected joints to count from 1 (", name,
            "1, ", name, "2, ...).");
    require(numbers[k] == expected, where, ": found ", name, numbers[k], " but no ", name, expected,
            ", expected joints without a hole (", name, "1 to ", name, "n).");
  }
  return static_cast<int>(numbers.size());
}

// Determines the number of joints from q; all other signals must agree.
void count_joints(const std::vector<ColumnName>& columns, const std::string& where, CsvLayout* layout) {
  std::vector<int> joints;
  for (int s = 0; s < kSignals; ++s) joints.push_back(joints_of(s, columns, where));
  layout->joints = joints[0];
  for (int s = 0; s < kSignals; ++s) {
    layout->has_signal.push_back(joints[s] > 0);
    require(joints[0] == 0 || joints[s] == 0 || joints[s] == joints[0], where, ": found ", joints[0],
            " joints in q but ", joints[s], " in ", kRecordingSignals[s].name,
            ", expected the same number in each signal.");
  }
}

// The names of all columns given by --columns, where "q" stands for q1 .. qn.
std::vector<std::string> names_of_columns(const std::vector<std::string>& columns, std::size_t fields, const std::string& where) {
  const bool has_time = columns.front() == "t";
  for (auto name = columns.begin() + (has_time ? 1 : 0); name != columns.end(); ++name) {
    require(signal_index(*name) >= 0, "--columns: found '", *name, "', expected q, dq, ddq, tau or i (t only as the first).");
    require(std::find(columns.begin(), name, *name) == name, "--columns: found '", *name, "' twice, expected it once.");
  }
  require(std::find(columns.begin(), columns.end(), "q") != columns.end(), "--columns: found no q, expected positions among the signals.");
  const std::size_t signals = columns.size() - (has_time ? 1 : 0), values = fields - (has_time ? 1 : 0);
  require(values >= signals && values % signals == 0, where, ": found ", fields,
          " columns, expected ", has_time ? "t and then " : "", "the same number of joints for each of the ", signals, " signals of --columns.");
  std::vector<std::string> names;
  for (const std::string& column : columns) {
    if (column == "t") names.push_back(column);
    for (std::size_t joint = 1; joint <= values / signals && column != "t"; ++joint) names.push_back(text(column, joint));
  }
  return names;
}

}  // namespace

char csv_separator(std::string_view line) {
  // If semicolons or tabs separate numbers, a comma is a decimal comma.
  const bool numbers = line.find_first_not_of("+-0123456789.,;eE \t\"naiNfF") == std::string_view::npos;
  char best = ' ';
  std::ptrdiff_t most = 0;
  for (const char candidate : {';', '\t', ','}) {
    bool quoted = false;
    std::ptrdiff_t count = 0;
    for (const char c : line) {
      if (c == '"') quoted = !quoted;
      count += !quoted && c == candidate ? 1 : 0;
    }
    if (numbers && count > 0) return candidate;
    if (count < most || count == 0) continue;
    best = candidate;
    most = count;
  }
  return best;
}

std::vector<std::string> csv_fields(std::string_view line, char separator) {
  std::vector<std::string> fields;
  std::string field;
  bool quoted = false;
  const auto finish = [&] {
    const std::size_t first = field.find_first_not_of(" \t");
    const std::size_t last = field.find_last_not_of(" \t");
    field = first == std::string::npos ? "" : field.substr(first, last - first + 1);
    if (separator != ' ' || !field.empty()) fields.push_back(field);
    field.clear();
  };
  for (const char c : line) {
    if (c == '"' || c == '\'') {
      quoted = !quoted;
    } else if (!quoted && (c == separator || (separator == ' ' && c == '\t'))) {
      finish();
    } else {
      field += c;
    }
  }
  finish();
  return fields;
}

bool is_missing_value(std::string field) {
  static const std::set<std::string> kNothing = {"null", "none", "nil", "na", "n/a", "#n/a", "#num!", "#value!", "#div/0!", "#ref!", "#name?", "-", "--"};
  return kNothing.count(to_lower(std::move(field))) > 0;
}

bool csv_number(std::string field, char separator, double* value) {
  if (separator != ',') std::replace(field.begin(), field.end(), ',', '.');
  *value = std::numeric_limits<double>::quiet_NaN();
  const bool plus = field.size() > 1 && field[0] == '+' && field[1] != '-';
  const char* const first = field.data() + (plus ? 1 : 0);
  const char* const last = field.data() + field.size();
  if (first == last) return true;
  double found = 0.0;
  const auto [rest, error] = std::from_chars(first, last, found);
  if (error == std::errc::invalid_argument || rest != last) return is_missing_value(std::move(field));
  // If the number is out of range for a double, strtod returns infinity or zero, as intended.
  *value = error == std::errc::result_out_of_range ? std::strtod(first, nullptr) : found;
  return true;
}

bool is_row_of_numbers(std::string_view line) {
  const char separator = csv_separator(line);
  const std::vector<std::string> fields = csv_fields(line, separator);
  double value = 0.0;
  return std::all_of(fields.begin(), fields.end(), [&](const std::string& field) { return csv_number(field, separator, &value); });
}

CsvLayout layout_from_header(std::string_view header, const std::string& where) {
  CsvLayout layout;
  layout.separator = csv_separator(header);
  layout.names = csv_fields(header, layout.separator);
  std::vector<ColumnName> columns;
  for (const std::string& name : layout.names) columns.push_back(column_name(name));
  count_joints(columns, where, &layout);
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const bool is_time = layout.names[k] == "t";
    require(!is_time || !layout.has_time, where, ":", k + 1, ": found column t twice, expected it once.");
    layout.has_time = layout.has_time || is_time;
    const bool is_signal = columns[k].signal >= 0 && columns[k].number >= 1;
    layout.slots.push_back(is_time ? CsvLayout::kTime : is_signal ? layout.slot(columns[k].signal, columns[k].number - 1) : CsvLayout::kIgnored);
  }
  suggest_missing(layout, columns, where);
  require(layout.joints > 0, where, ": found columns ", first_names(layout.names),
          ", expected a header with t and q1 to qn.");
  return layout;
}

CsvLayout layout_from_columns(const std::vector<std::string>& columns, std::string_view first_row,
                              const std::string& where) {
  const char separator = csv_separator(first_row);
  const std::size_t fields = csv_fields(first_row, separator).size();
  const bool each_joint = std::any_of(columns.begin(), columns.end(), [](const std::string& name) {
    return !name.empty() && is_number(name.substr(name.size() - 1));
  });
  std::string header;
  for (const std::string& name : each_joint ? columns : names_of_columns(columns, fields, where)) header += (header.empty() ? "" : ",") + name;
  require(!each_joint || fields == columns.size(), where, ": found ", fields, " columns, expected the ", columns.size(), " of --columns ", header, ".");
  CsvLayout layout = layout_from_header(header, where);
  layout.separator = separator;
  return layout;
}

}  // namespace veridyn
