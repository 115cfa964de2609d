#pragma once

#include <memory>
#include <string>
#include <vector>

#include "recordings/kept_recordings.hpp"
#include "veridyn/recordings/preprocessing.hpp"

namespace veridyn {

/// [rad/s], [m/s] velocity that stands for the direction from which a joint came to rest: dry friction has its full level.
constexpr double kApproachSpeed = 1e-4;

/// True if all of these recordings are poses at rest.
/// @throws InvalidInput  some are and some are not.
bool are_poses(const PreprocessingOptions& how, const std::vector<std::string>& names);

/// Changes options so that they leave poses at rest as they are.
void keep_poses(const std::vector<std::string>& names, PreprocessingOptions& how);

/// Names of the recordings of a call; those in memory are stored in the options' `in_memory`, which both
/// lists of recordings share. The options of poses at rest leave these as they are.
template <typename Options>
struct NamedRecordings {
  std::vector<std::string> train, test;
  Options how;
  bool poses = false;  ///< all recordings are poses at rest

  NamedRecordings(const Recordings& train_list, const Recordings& test_list, const Options& options)
      : how(options) {
    train = train_list.register_in(how.preprocessing.in_memory);
    test = test_list.register_in(how.preprocessing.in_memory);
    if (how.test_preprocessing)
      how.test_preprocessing->in_memory = how.preprocessing.in_memory;
    std::vector<std::string> all = train;
    all.insert(all.end(), test.begin(), test.end());
    poses = are_poses(how.preprocessing, all);
    if (!poses) return;
    how.test_preprocessing.reset();
    keep_poses(all, how.preprocessing);
  }
};

/// Keeps parsed files in memory, up to `most_bytes` of text in total, unless the caller has set `kept`.
template <typename Options>
void keep_recordings(Options& how, long most_bytes) {
  if (!how.preprocessing.kept)
    how.preprocessing.kept = std::make_shared<KeptRecordings>(most_bytes);
  if (how.test_preprocessing) how.test_preprocessing->kept = how.preprocessing.kept;
}

/// Removes recordings in memory and callbacks from the options inside a result, which would otherwise keep
/// them alive.
template <typename Result>
void drop_recordings(Result& result) {
  for (PreprocessingOptions* how : {&result.preprocessing, &result.test_preprocessing}) {
    how->in_memory.clear();
    how->kept.reset();
    how->interrupted = nullptr;
  }
}

}  // namespace veridyn
