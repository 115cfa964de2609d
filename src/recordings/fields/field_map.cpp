#include "recordings/fields/field_map.hpp"

#include <algorithm>
#include <iterator>

#include "files/words.hpp"
#include "model/suggestion.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/recordings/recording.hpp"

namespace veridyn::recordings {
namespace {

constexpr std::size_t kColumnDigits = 6, kJointDigits = 4;  // largest number of digits of a column's and of a joint's number

// Normalised name, in which `a[3]/b.c` and `a/3/b/c` are equal.
std::string normalized_name(const std::string& name) {
  std::string out;
  for (const char c : name) {
    if (c == ']') continue;
    out += c == '[' || c == '.' ? '/' : c;
  }
  return out;
}

// All names that --map accepts for a column: with and without its topic and `data/`.
std::vector<std::string> names_of(const RawStream& stream, const RawField& field) {
  std::vector<std::string> names = {normalized_name(field.path)};
  if (stream.topic.empty()) return names;
  names.push_back(normalized_name(stream.topic + "/" + field.path));
  std::string brief = "/" + names.back();
  const std::size_t data = brief.rfind("/data/");
  if (data != std::string::npos) brief.erase(data, 5);
  names.push_back(brief.substr(1));
  return names;
}

// The number after a prefix, for example 3 in `tau_3` after `tau`; nullopt without one.
std::optional<long> number_after_prefix(const std::string& name, const std::string& prefix) {
  if (name.size() <= prefix.size() || !starts_with(name, prefix)) return std::nullopt;
  const std::size_t digits = name.find_first_not_of("/_", prefix.size());
  if (digits == std::string::npos || name.size() - digits > kColumnDigits || !is_number(name.substr(digits))) return std::nullopt;
  return std::stol(name.substr(digits));
}

std::optional<FieldPlace> field_by_name(const RawRecording& raw, const std::string& source) {
  const std::string wanted = normalized_name(source);
  return longest_field(raw, [&](const RawStream& stream, const RawField& field) {
    const std::vector<std::string> names = names_of(stream, field);
    return std::find(names.begin(), names.end(), wanted) != names.end();
  });
}

// Columns whose names are the source followed by a number, in the order of these numbers.
std::map<long, FieldPlace> columns(const RawRecording& raw, const std::string& source) {
  std::map<long, FieldPlace> found;
  for (std::size_t s = 0; s < raw.streams.size(); ++s) {
    for (std::size_t f = 0; f < raw.streams[s].fields.size(); ++f) {
      for (const std::string& name : names_of(raw.streams[s], raw.streams[s].fields[f])) {
        if (const auto number = number_after_prefix(name, normalized_name(source)))
          found.try_emplace(*number, FieldPlace{static_cast<int>(s), static_cast<int>(f)});
      }
    }
  }
  return found;
}

struct Key {
  int signal = -1;
  std::size_t joint = 0;  // number of the joint from 1; 0: all
};

// The signal and joint of a key such as `tau1` or `tau`.
std::optional<Key> key_of(const std::string& text) {
  const std::size_t digits = text.find_last_not_of("0123456789") + 1;
  const std::string number = text.substr(digits);
  for (int signal = 0; signal < kSignalCount; ++signal) {
    if (text.substr(0, digits) != kRecordingSignals[signal].name) continue;
    if (number.empty()) return Key{signal, 0};
    const std::size_t joint = number.size() > kJointDigits ? 0 : std::stoul(number);
    if (joint > 0) return Key{signal, joint};
  }
  return std::nullopt;
}

[[noreturn]] void fail(const std::string& path, const std::string& key, const std::string& source,
                       const RawRecording& raw) {
  std::vector<std::string> names;
  for (const RawStream& stream : raw.streams) {
    for (const RawField& field : stream.fields)
      names.push_back(stream.topic.empty() ? field.path : stream.topic + "/" + field.path);
  }
  throw InvalidInput(text(path, ": --map ", key, "=", source, ": the recording has no ", source, did_you_mean(source, names),
                          "; it has ", first_listed(names), "."));
}

// Finds the column that a source names for one joint's signal.
void map_one(const RawRecording& raw, const std::string& path, const Key& signal, const std::string& key, const std::string& source, FieldMap* map) {
  const FieldMap::Signal at{signal.signal, signal.joint - 1};
  const std::optional<FieldPlace> place = field_by_name(raw, source);
  const std::optional<Key> other = key_of(source);
  if (place) {
    map->places[at] = *place;
  } else if (other && other->joint > 0) {
    map->taken[at] = {other->signal, other->joint - 1};
  } else {
    fail(path, key, source, raw);
  }
}

// Finds the columns that a source names for all joints' signals; a single joint may have a single column.
void map_all(const RawRecording& raw, const std::string& path, std::size_t wanted, const Key& signal, const std::string& key, const std::string& source,
             FieldMap* map) {
  const std::map<long, FieldPlace> found = columns(raw, source);
  if (found.empty()) {
    const std::optional<FieldPlace> one = field_by_name(raw, source);
    if (!one) fail(path, key, source, raw);
    map->places[{signal.signal, 0}] = *one;
    return;
  }
  require(wanted == 0 || found.size() == wanted, path, ": --map ", key, "=", source, ": found ",
          found.size(), " columns, expected ", wanted, ", one for each joint.");
  std::size_t joint = 0;
  for (const auto& [number, place] : found) map->places[{signal.signal, joint++}] = place;
}

}  // namespace

FieldMap field_map(const RawRecording& raw, const std::string& path, const SignalChoice& choice) {
  FieldMap map;
  std::vector<std::string> joints;
  for (const WantedJoint& joint : choice.joints) joints.push_back(joint.name);
  for (const auto& [key, source] : choice.map) {
    if (key == "t") continue;  // the reader of the table has used it as the time
    const std::optional<Key> signal = key_of(key);
    if (std::find(joints.begin(), joints.end(), key) != joints.end()) {
      map.renamed[key] = source;
    } else if (!signal) {
      throw InvalidInput(text("--map: found '", key, "', expected a signal as tau1 or tau, t, or a joint",
                              joints.empty() ? "" : " of " + listed(joints), "."));
    } else if (signal->joint > 0) {
      map_one(raw, path, *signal, key, source, &map);
    } else {
      map_all(raw, path, joints.size(), *signal, key, source, &map);
    }
  }
  return map;
}

std::optional<FieldPlace> FieldMap::place(int signal, std::size_t joint) const {
  const auto found = places.find({signal, joint});
  return found == places.end() ? std::nullopt : std::make_optional(found->second);
}

bool FieldMap::maps_signal(int signal) const {
  const auto first = places.lower_bound({signal, 0});
  return first != places.end() && first->first.first == signal;
}

std::size_t FieldMap::mapped_joints(std::size_t wanted) const {
  std::size_t joints = 0;
  while (place(0, joints)) ++joints;
  if (wanted > 0) return joints >= wanted ? wanted : 0;
  const auto mapped = std::distance(places.begin(), places.lower_bound({1, 0}));
  return static_cast<std::size_t>(mapped) == joints ? joints : 0;
}

}  // namespace veridyn::recordings
