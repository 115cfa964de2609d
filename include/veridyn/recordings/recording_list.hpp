#pragma once

#include <initializer_list>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "veridyn/recordings/recording.hpp"

namespace veridyn {

/// Recordings in memory, by name.
using RecordingsInMemory = std::map<std::string, std::shared_ptr<const Recording>>;

/// A list of recordings: paths of files, recordings in memory, or both, in the order in which they
/// were added.
///
///   identify(arm, {"one.csv", "two.csv"});        // paths
///   identify(arm, {recorded_today}, {"old.csv"}); // in memory, held out from a file
///
/// A recording in memory is named by its `source`, or "recording 1", "recording 2", ... if that is
/// empty; a name in use gets a number. It is copied once, or shared.
class Recordings {
 public:
  Recordings() = default;
  Recordings(std::vector<std::string> paths);           // NOLINT: a list of paths is one
  Recordings(std::initializer_list<std::string> paths);
  Recordings(const std::vector<Recording>& in_memory);  // NOLINT: and so are recordings
  Recordings(std::initializer_list<Recording> in_memory);
  Recordings(const Recording& in_memory) { add(in_memory); }  // NOLINT

  void add(const std::string& path) { names_.push_back(path); }
  void add(const Recording& recording) { add(std::make_shared<const Recording>(recording)); }
  void add(std::shared_ptr<const Recording> recording);

  bool empty() const { return names_.empty(); }
  const std::vector<std::string>& names() const { return names_; }

  /// Names of all recordings; those in memory are added to `memory`, under names that are unique
  /// there.
  std::vector<std::string> register_in(RecordingsInMemory& memory) const;

 private:
  std::vector<std::string> names_;
  RecordingsInMemory in_memory_;
};

/// The recording of that name, or null if it has to be read from a file.
const Recording* find_in_memory(const RecordingsInMemory& memory, const std::string& name);

}  // namespace veridyn
