#include "recordings/fields/field_map.hpp"

#include <algorithm>
#include <optional>

#include "recordings/signals/joint_fields.hpp"
#include "veridyn/math/require.hpp"
#include "model/suggestion.hpp"
#include "veridyn/recordings/recording.hpp"

namespace veridyn::recordings {
namespace {

// Normalised name, in which `a[3]/b.c` and `a/3/b/c` are equal.
std::string normalized_name(std::string name) {
  std::string out;
  for (const char c : name) {
    if (c == ']') continue;
    out += c == '[' || c == '.' ? '/' : c;
  }
  return out;
}

std::string without_data_suffix(const std::string& name) {
  const std::size_t data = name.rfind("/data/");
  return data == std::string::npos ? name : name.substr(0, data) + name.substr(data + 5);
}

// All names by which --map may call a column.
std::vector<std::string> names_of(const RawStream& stream, const RawField& field) {
  std::vector<std::string> names = {normalized_name(field.path)};
  if (!stream.topic.empty()) {
    names.push_back(normalized_name(stream.topic + "/" + field.path));
    names.push_back(without_data_suffix("/" + names.back()).substr(1));
  }
  return names;
}

// The number after a prefix, for example 3 in `tau_3` after `tau`; nullopt without one.
std::optional<long> number_after_prefix(const std::string& name, const std::string& prefix) {
  if (name.size() <= prefix.size() || name.compare(0, prefix.size(), prefix) != 0)
    return std::nullopt;
  std::string rest = name.substr(prefix.size());
  while (!rest.empty() && (rest.front() == '/' || rest.front() == '_')) rest.erase(rest.begin());
  if (rest.empty() || rest.size() > 6 || rest.find_first_not_of("0123456789") != std::string::npos)
    return std::nullopt;
  return std::stol(rest);
}

std::optional<FieldPlace> column(const RawRecording& raw, const std::string& source) {
  std::optional<FieldPlace> best;
  std::size_t rows = 0;
  for (std::size_t s = 0; s < raw.streams.size(); ++s) {
    for (std::size_t f = 0; f < raw.streams[s].fields.size(); ++f) {
      const std::vector<std::string> names = names_of(raw.streams[s], raw.streams[s].fields[f]);
      const bool same = std::find(names.begin(), names.end(), normalized_name(source)) != names.end();
      if (!same || raw.streams[s].rows() <= rows) continue;
      best = FieldPlace{static_cast<int>(s), static_cast<int>(f)};
      rows = raw.streams[s].rows();
    }
  }
  return best;
}

// Columns whose names are the source followed by a number, in the order of these numbers.
std::vector<FieldPlace> columns(const RawRecording& raw, const std::string& source) {
  std::map<long, FieldPlace> found;
  for (std::size_t s = 0; s < raw.streams.size(); ++s) {
    for (std::size_t f = 0; f < raw.streams[s].fields.size(); ++f) {
      for (const std::string& name : names_of(raw.streams[s], raw.streams[s].fields[f])) {
        if (const auto number = number_after_prefix(name, normalized_name(source)))
          found.try_emplace(*number, FieldPlace{static_cast<int>(s), static_cast<int>(f)});
      }
    }
  }
  std::vector<FieldPlace> out;
  for (const auto& [number, place] : found) out.push_back(place);
  return out;
}

// On a topic with named joints, the caller finds this signal of each joint.
std::vector<std::string> all_columns(const RawRecording& raw) {
  std::vector<std::string> names;
  for (const RawStream& stream : raw.streams) {
    for (const RawField& field : stream.fields)
      names.push_back(stream.topic.empty() ? field.path : stream.topic + "/" + field.path);
  }
  return names;
}

struct Key {
  int signal = -1;
  std::size_t joint = 0;  // from 1; 0: all
};

std::optional<Key> key_of(const std::string& text) {
  const std::size_t digits = text.find_last_not_of("0123456789") + 1;
  for (int signal = 0; signal < kSignalCount; ++signal) {
    if (text.substr(0, digits) != kRecordingSignals[signal].name) continue;
    if (digits == text.size()) return Key{signal, 0};
    if (text.size() - digits > 4) return std::nullopt;
    const auto joint = static_cast<std::size_t>(std::stoul(text.substr(digits)));
    if (joint > 0) return Key{signal, joint};
  }
  return std::nullopt;
}

[[noreturn]] void fail(const std::string& path, const std::string& key, const std::string& source,
                       const RawRecording& raw) {
  std::vector<std::string> names = all_columns(raw);
  const std::string guess = did_you_mean(source, names);
  const std::size_t all = names.size();
  if (all > 12) names.resize(12);
  throw InvalidInput(text(path, ": --map ", key, "=", source, ": the recording has no ", source, guess,
                          "; it has ", listed(names), all > 12 ? text(", ... (", all, ")") : "", "."));
}

}  // namespace

FieldMap::FieldMap(const RawRecording& raw, const std::string& path, const SignalChoice& choice)
    : wanted_(choice.joints.size()) {
  for (const auto& [key, source] : choice.map) {
    const auto joint = std::find_if(choice.joints.begin(), choice.joints.end(),
                                    [&k = key](const WantedJoint& j) { return j.name == k; });
    const std::optional<Key> signal = key_of(key);
    if (key == "t") continue;  // the reader of the table has used it as the time
    if (joint != choice.joints.end()) {
      renamed_[key] = source;
    } else if (!signal) {
      std::vector<std::string> names;
      for (const WantedJoint& j : choice.joints) names.push_back(j.name);
      throw InvalidInput(text("--map: found '", key,
                              "', expected a signal as tau1 or tau, t, or a joint",
                              names.empty() ? "" : " of " + listed(names), "."));
    } else if (signal->joint > 0) {
      const std::optional<FieldPlace> place = column(raw, source);
      const std::optional<Key> other = key_of(source);
      if (!place && other && other->joint > 0) {
        taken_[{signal->signal, signal->joint - 1}] = {other->signal, other->joint - 1};
        continue;
      }
      if (!place) fail(path, key, source, raw);
      places_[{signal->signal, signal->joint - 1}] = *place;
    } else {
      const std::vector<FieldPlace> found = columns(raw, source);
      const std::optional<FieldPlace> one = found.empty() ? column(raw, source) : std::nullopt;
      if (one) {
        places_[{signal->signal, 0}] = *one;
        continue;
      }
      if (found.empty()) fail(path, key, source, raw);
      require(wanted_ == 0 || found.size() == wanted_, path, ": --map ", key, "=", source, ": found ",
              found.size(), " columns, expected ", wanted_, ", one for each joint.");
      for (std::size_t j = 0; j < found.size(); ++j) places_[{signal->signal, j}] = found[j];
    }
  }
}

std::optional<FieldPlace> FieldMap::place(int signal, std::size_t joint) const {
  const auto found = places_.find({signal, joint});
  return found == places_.end() ? std::nullopt : std::make_optional(found->second);
}

bool FieldMap::maps_signal(int signal) const {
  return std::any_of(places_.begin(), places_.end(),
                     [signal](const auto& entry) { return entry.first.first == signal; });
}

std::size_t FieldMap::largest_joint() const {
  std::size_t largest = 0;
  for (const auto& [key, place] : places_) {
    if (key.first == 0) largest = std::max(largest, key.second + 1);
  }
  return largest;
}

bool FieldMap::maps_all_positions() const {
  const std::size_t n = wanted_ > 0 ? wanted_ : largest_joint();
  if (n == 0) return false;
  for (std::size_t j = 0; j < n; ++j) {
    if (!place(0, j)) return false;
  }
  return true;
}

}  // namespace veridyn::recordings
