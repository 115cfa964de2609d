#include "recordings/arrays/array_recording.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "model/excerpt.hpp"
#include "recordings/csv/time_column.hpp"
#include "recordings/signals/joint_fields.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::recordings {
namespace {

constexpr std::size_t kNamed = 12;         // largest number of arrays that a message lists
constexpr std::size_t kMostGroups = 1000;  // largest number of groups of arrays with signals; each is compared with all arrays

std::string group_of(const std::string& name) {
  const std::size_t slash = name.rfind('/');
  return slash == std::string::npos ? std::string() : name.substr(0, slash);
}

std::string name_without_group(const std::string& name) {
  return name.substr(name.rfind('/') + 1);
}

bool is_vector(const NamedArray& a) {
  return a.rows == 1 || a.columns == 1;
}

std::size_t size_of(const NamedArray& a) {
  return a.rows * a.columns;
}

// The clock of a group: the array of times in the group itself, or else that of the file.
const NamedArray* clock_for(const ArraySet& set, const std::string& group,
                            const std::string& wanted, TimeColumns* found) {
  for (const std::string& place : {group, std::string()}) {
    std::vector<const NamedArray*> vectors;
    std::vector<std::string> names;
    for (const NamedArray& a : set.arrays) {
      if (group_of(a.name) != place || !is_vector(a) || size_of(a) < 2) continue;
      vectors.push_back(&a);
      names.push_back(name_without_group(a.name));
    }
    *found = time_columns(names, name_without_group(wanted));
    if (found->recorded) return vectors[*found->recorded];
  }
  return nullptr;
}

// Element `k` of sample `row`, in either orientation of the array.
double element(const NamedArray& a, std::size_t rows, std::size_t row, std::size_t k) {
  const bool lying = a.rows != rows && a.columns == rows;
  return lying ? a.values[k * a.columns + row] : a.values[row * a.columns + k];
}

// True if --map takes a signal from this array, or from one of its columns.
bool is_mapped(const std::string& name, const SignalChoice& choice) {
  return std::any_of(choice.map.begin(), choice.map.end(), [&name](const auto& entry) {
    const std::string& source = entry.second;
    return source.compare(0, name.size(), name) == 0 &&
           source.find_first_not_of("/_[]0123456789", name.size()) == std::string::npos;
  });
}

// Columns of an array that has one row, or one column, for each of `rows` times; 0: it has neither.
std::size_t column_count_of(const NamedArray& a, std::size_t rows) {
  if (a.rows == rows) return a.columns;
  return a.columns == rows ? a.rows : 0;
}

void add_group(const ArraySet& set, const std::string& path, const std::string& group,
               const RecordingOptions& options, RawRecording* raw) {
  TimeColumns columns;
  const auto named = options.signals.map.find("t");
  const NamedArray* clock = clock_for(
      set, group, named == options.signals.map.end() ? std::string() : named->second, &columns);
  require(clock != nullptr || options.rate > 0.0, path,
          ": found no array of times (t, time, timestamp), expected one, or --rate.");
  std::size_t rows = clock != nullptr ? size_of(*clock) : 0;
  for (const NamedArray& a : set.arrays) {
    // Without an array of times, the longer dimension of the positions, or of the arrays in --map, is the time
    // axis.
    const bool longest = field_of(name_without_group(a.name) + "/0").signal == 0 || is_mapped(a.name, options.signals);
    if (clock == nullptr && group_of(a.name) == group && longest) rows = std::max({rows, a.rows, a.columns});
  }
  RawStream stream;
  stream.topic = group;
  std::vector<const NamedArray*> kept;
  for (const NamedArray& a : set.arrays) {
    if (group_of(a.name) != group || &a == clock || rows == 0) continue;
    const std::size_t width = column_count_of(a, rows);
    if (width == 0 || width > 256) continue;
    kept.push_back(&a);
    const std::string name = name_without_group(a.name);
    for (std::size_t k = 0; k < width; ++k) {
      RawField field = width == 1 ? field_of(name) : field_of(name + "/" + std::to_string(k));
      field.path = width == 1 ? name : name + "/" + std::to_string(k);
      if (field.signal >= 0 && width > 1 && set.joint_names.size() == width)
        field.joint = set.joint_names[k];
      stream.fields.push_back(std::move(field));
    }
  }
  if (stream.fields.empty()) return;
  std::int64_t unit = 0;
  if (clock != nullptr) {
    const std::vector<double> first(clock->values.begin(), clock->values.begin() + static_cast<long>(std::min(clock->values.size(), kTimesForUnit)));
    const bool whole = std::all_of(first.begin(), first.end(), [](double t) { return t == std::floor(t); });
    unit = time_unit(options.signals, columns.unit, first, whole, &raw->remarks);
  }
  for (std::size_t row = 0; row < rows; ++row) {
    const double t = clock != nullptr ? clock->values[row] * static_cast<double>(unit)
                                      : static_cast<double>(row) * 1e9 / options.rate;
    if (!std::isfinite(t) || std::abs(t) > static_cast<double>(kLargestTime)) continue;
    stream.recorded.push_back(std::llround(t));
    for (const NamedArray* a : kept) {
      const std::size_t width = column_count_of(*a, rows);
      for (std::size_t k = 0; k < width; ++k) stream.values.push_back(element(*a, rows, row, k));
    }
  }
  raw->streams.push_back(std::move(stream));
}

}  // namespace

RawRecording raw_from_arrays(ArraySet set, const std::string& path, const std::string& format,
                             const RecordingOptions& options) {
  RawRecording raw;
  raw.format = format;
  std::set<std::string> known;
  std::vector<std::string> groups;
  for (const NamedArray& a : set.arrays) {
    const bool signal = field_of(name_without_group(a.name) + "/0").signal >= 0;
    const bool mapped = !options.signals.map.empty();
    if (!signal && !mapped) continue;
    if (known.insert(group_of(a.name)).second) groups.push_back(group_of(a.name));
  }
  if (groups.empty()) {
    std::string names;
    for (std::size_t k = 0; k < std::min(set.arrays.size(), kNamed); ++k) names += (k == 0 ? "" : ", ") + excerpt(set.arrays[k].name);
    if (set.arrays.size() > kNamed) names += text(", ... (", set.arrays.size(), ")");
    throw InvalidInput(text(path, ": found arrays ", names.empty() ? "of no numbers" : names,
                            ", expected t, q, dq and tau (samples by joints); --map names others."));
  }
  require(groups.size() <= kMostGroups, path, ": found ", groups.size(), " groups of arrays with signals, expected at most ", kMostGroups, ".");
  for (const std::string& group : groups) add_group(set, path, group, options, &raw);
  return raw;
}

}  // namespace veridyn::recordings
