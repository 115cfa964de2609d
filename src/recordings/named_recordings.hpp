#pragma once

#include <string>
#include <vector>

#include "veridyn/recordings/preprocessing.hpp"

namespace veridyn {

/// A question's recordings by name; those in memory are found in the options' `in_memory`, which
/// both kinds of recordings share.
template <typename Options>
struct NamedRecordings {
  std::vector<std::string> train, test;
  Options how;

  NamedRecordings(const Recordings& train_list, const Recordings& test_list, const Options& options)
      : how(options) {
    train = train_list.placed_in(how.preprocessing.in_memory);
    test = test_list.placed_in(how.preprocessing.in_memory);
    if (how.test_preprocessing)
      how.test_preprocessing->in_memory = how.preprocessing.in_memory;
  }
};

/// Results do not keep recordings alive, nor what may interrupt a run.
template <typename Result>
void forget_recordings(Result& result) {
  for (PreprocessingOptions* how : {&result.preprocessing, &result.test_preprocessing}) {
    how->in_memory.clear();
    how->kept.reset();
    how->interrupted = nullptr;
  }
}

}  // namespace veridyn
