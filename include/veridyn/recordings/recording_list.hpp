#pragma once

#include <initializer_list>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "veridyn/recordings/recording.hpp"

namespace veridyn {

/// Recordings that are in memory, by the name under which a question speaks of them.
using RecordingsInMemory = std::map<std::string, std::shared_ptr<const Recording>>;

/// The recordings of one question: paths of files, recordings in memory, or some of both, in the
/// order in which they were added.
///
///   identify(arm, {"one.csv", "two.csv"});        // paths
///   identify(arm, {recorded_today}, {"old.csv"}); // in memory, held out from a file
///
/// A recording in memory is known by its `source`, or as "recording 1", "recording 2", ... where
/// that is empty; a name that is taken already gets a number. It is copied once, or shared.
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

  /// Names of all of them; those in memory are added to `memory`, under names that are new there.
  std::vector<std::string> placed_in(RecordingsInMemory& memory) const;

 private:
  std::vector<std::string> names_;
  RecordingsInMemory in_memory_;
};

/// The recording of that name, or null where it has to be read from a file.
const Recording* find_in_memory(const RecordingsInMemory& memory, const std::string& name);

}  // namespace veridyn
