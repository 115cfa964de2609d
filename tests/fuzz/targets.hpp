#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace veridyn {

/// A reader of files or bytes from outside, for the fuzzer and for the test that replays the corpus.
struct FuzzTarget {
  std::string name;  ///< its folder in tests/fuzz/corpus, too
  /// Reads the bytes; what was read is written and read again where the library has a writer.
  /// @returns the contradiction found; empty: none. InvalidInput is caught, nothing else is.
  std::string (*probe)(std::string_view bytes);
  /// Whole inputs: files of this project and what its writers make.
  std::vector<std::string> (*seeds)();
};

/// Those of the library and of the packages that are built.
const std::vector<FuzzTarget>& fuzz_targets();

/// Registers readers: a constant in the file that has them.
struct AddFuzzTargets {
  explicit AddFuzzTargets(const std::vector<FuzzTarget>& targets);
};

}  // namespace veridyn
