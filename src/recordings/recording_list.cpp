#include "veridyn/recordings/recording_list.hpp"

#include <algorithm>

#include "recordings/named_recordings.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

// The name `wanted`, followed by a number if another recording has this name.
std::string free_name(const std::string& wanted, const RecordingsInMemory& taken) {
  std::string name = wanted;
  for (int k = 2; taken.count(name) > 0; ++k) name = text(wanted, " (", k, ")");
  return name;
}

}  // namespace

Recordings::Recordings(std::vector<std::string> paths) : names_(std::move(paths)) {}

Recordings::Recordings(std::initializer_list<std::string> paths) : names_(paths) {}

Recordings::Recordings(const std::vector<Recording>& in_memory) {
  for (const Recording& recording : in_memory) add(recording);
}

Recordings::Recordings(std::initializer_list<Recording> in_memory) {
  for (const Recording& recording : in_memory) add(recording);
}

void Recordings::add(std::shared_ptr<const Recording> recording) {
  require(recording != nullptr && recording->rows() > 0,
          "recordings: found one without rows, expected time, q and tau.");
  const std::string wanted =
      recording->source.empty() ? text("recording ", names_.size() + 1) : recording->source;
  const std::string name = free_name(wanted, in_memory_);
  names_.push_back(name);
  in_memory_.emplace(name, std::move(recording));
}

std::vector<std::string> Recordings::register_in(RecordingsInMemory& memory) const {
  std::vector<std::string> out;
  for (const std::string& name : names_) {
    const auto own = in_memory_.find(name);
    if (own == in_memory_.end()) {
      out.push_back(name);
      continue;
    }
    const auto there = memory.find(name);
    const bool same = there != memory.end() && there->second == own->second;
    out.push_back(same ? name : free_name(name, memory));
    memory.emplace(out.back(), own->second);
  }
  return out;
}

const Recording* find_in_memory(const RecordingsInMemory& memory, const std::string& name) {
  const auto found = memory.find(name);
  return found == memory.end() ? nullptr : found->second.get();
}

bool are_poses(const PreprocessingOptions& how, const std::vector<std::string>& names) {
  const auto is_table = [&how](const std::string& name) {
    const Recording* there = find_in_memory(how.in_memory, name);
    return there != nullptr && there->poses;
  };
  const auto other = std::find_if_not(names.begin(), names.end(), is_table);
  if (other == names.end()) return !names.empty();
  require(std::none_of(names.begin(), names.end(), is_table), *other, ": found a motion beside poses at rest, expected either.");
  return false;
}

void keep_poses(const std::vector<std::string>& names, PreprocessingOptions& how) {
  how.cutoff = how.drop_start = how.drop_end = how.min_speed = 0.0;
  how.filtering = Filtering::kSignals;
  how.decimation = 1;
  how.first_row = 0;
  how.row_count.reset();
  for (const std::string& name : names) how.known_periods[name] = 0.0;
}

}  // namespace veridyn
