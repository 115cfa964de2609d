#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>

#include "effects/effect_names.hpp"

// An effect's name stands in its own file. Where another room spells it, the next effect will be
// treated wrongly there, and nobody will notice.

namespace {

namespace fs = std::filesystem;

// Words that are something else as well.
bool allowed(const fs::path& file, const std::string& word) {
  static const std::map<std::string, std::set<std::string>> kAllowed = {
      {"payload", {"payload.cpp", "payload_command.cpp", "payload_json.cpp"}},  // a command and its function
      // A key of a coordinate's `recorded:` in robot files.
      {"torque_gain", {"model_file_reader.cpp", "model_file_writer.cpp"}},
      {"torque_crosstalk", {"model_file_reader.cpp", "model_file_writer.cpp"}}};
  const auto files = kAllowed.find(word);
  return files != kAllowed.end() && files->second.count(file.filename().string()) > 0;
}

TEST(EffectNames, StandInTheirOwnFilesAlone) {
  const std::vector<std::string>& names = veridyn::effect_names();
  const std::set<std::string> known(names.begin(), names.end());
  static const std::regex kLiteral("\"([a-z_]+)[\":]");
  int files = 0;
  for (const char* root : {VERIDYN_SOURCE_DIR "/src", VERIDYN_SOURCE_DIR "/include/veridyn"}) {
    for (const auto& entry : fs::recursive_directory_iterator(root)) {
      const fs::path path = fs::relative(entry.path(), root);
      const std::string kind = path.extension().string();
      if ((kind != ".cpp" && kind != ".hpp") || *path.begin() == "effects") continue;
      ++files;
      std::ifstream stream(entry.path());
      std::string line;
      for (int number = 1; std::getline(stream, line); ++number) {
        const std::string code = line.substr(0, line.find("//"));
        for (std::sregex_iterator it(code.begin(), code.end(), kLiteral), end; it != end; ++it) {
          const std::string word = (*it)[1];
          EXPECT_TRUE(known.count(word) == 0 || allowed(path, word))
              << path.string() << ":" << number << ": the name of an effect, '" << word
              << "': ask Effect::traits() instead";
        }
      }
    }
  }
  EXPECT_GT(files, 300);
}

}  // namespace
