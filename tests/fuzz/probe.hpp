#pragma once

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "fuzz/targets.hpp"
#include "recordings/samples.hpp"
#include "support/file_in_memory.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {

namespace fs = std::filesystem;
using Seeds = std::vector<std::string>;

inline constexpr std::size_t kLongestMessage = 4000;  // a line that a terminal still shows as a whole

// Files of this project below a folder, smaller than 200 kB, whose paths hold one of the words.
inline Seeds files(const std::string& folder, const std::vector<std::string>& words) {
  std::vector<std::string> paths;
  for (const fs::directory_entry& entry :
       fs::recursive_directory_iterator(VERIDYN_SOURCE_DIR "/" + folder)) {
    const std::string path = entry.path().string();
    if (!entry.is_regular_file() || entry.file_size() > 200000) continue;
    for (const std::string& word : words)
      if (path.find(word) != std::string::npos) {
        paths.push_back(path);
        break;
      }
  }
  std::sort(paths.begin(), paths.end());
  Seeds out;
  for (const std::string& path : paths) out.push_back(bytes_of_file(path));
  return out;
}

// Runs a reader. A refusal has to be one line.
template <typename Read>
std::string refusal_or(const Read& read) {
  try {
    return read();
  } catch (const InvalidInput& refused) {
    const std::string message = refused.what();
    if (message.empty()) return "a refusal without a word";
    if (message.size() > kLongestMessage) return "a refusal of " + text(message.size()) + " bytes";
    if (message.find('\n') != std::string::npos) return "a refusal of several lines: " + message;
    return "";
  }
}

// Degrees in files are radians here: numbers may differ in their last digit.
enum class Again { kSame, kAccepted };

// What a writer makes of an accepted input is accepted, and written the same again.
template <typename Write, typename Read>
std::string written_again(const Write& write, const Read& read, Again expected = Again::kSame) {
  const std::string first = write();
  try {
    const std::string second = read(first);
    if (expected == Again::kAccepted || second == first) return "";
    return "written differently the second time: " + first + "\n" + second;
  } catch (const InvalidInput& refused) {
    return std::string("refused what was written: ") + refused.what() + "\n" + first;
  }
}

}  // namespace veridyn
