#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <random>
#include <sstream>

#include "cli/tool.hpp"

// Wrong command lines of every command, drawn from the options that the tool's own help lists: each ends with status 2
// or 3 and one line, and leaves no file.

namespace veridyn {
namespace {

constexpr int kLines = 240;
constexpr int kExtremeLines = 120;
constexpr unsigned kLongest = 120;  // [s] until a run counts as hanging, on a machine of any load

struct Option {
  std::string name;
  std::string value;  ///< as the help shows it, empty: a flag

  bool takes_value() const { return !value.empty() && value[0] != '['; }
  bool once() const { return takes_value() && value.find("...") == std::string::npos && value.find('=') == std::string::npos && name != "--topic"; }
  bool number() const {
    static const Words kKinds = {"HZ", "S", "N", "V", "X", "M", "P", "Z", "MS", "BYTES", "BITS", "DEGREES", "COUNT", "PORT", "K"};
    return std::find(kKinds.begin(), kKinds.end(), value) != kKinds.end();
  }
  bool output() const {
    static const Words kNames = {"--json", "--report", "--yaml", "--output", "--model-out", "--factor-out", "--robot-out", "--coefficients"};
    return std::find(kNames.begin(), kNames.end(), name) != kNames.end();
  }
};

bool has_common_options(const std::string& command) { return command != "help" && command != "dvrk config"; }

// The options of each command, which `veridyn help --markdown` lists.
std::map<std::string, std::vector<Option>> options_of_commands(const TemporaryFolder& folder) {
  const std::string path = folder.path("help.md");
  EXPECT_EQ(run_tool({"help", "--markdown", path}).status, 0);
  std::istringstream help(content_of(path));
  std::map<std::string, std::vector<Option>> out;
  std::string command;
  for (std::string line; std::getline(help, line);) {
    if (line.rfind("## veridyn ", 0) == 0) command = line.substr(11);
    if (line.rfind("| `-", 0) != 0) continue;
    const std::string shown = line.substr(3, line.find('`', 3) - 3);
    const std::size_t names_end = shown.find(' ');
    const std::string names = shown.substr(0, names_end);
    const std::size_t comma = names.rfind(',');
    std::vector<Option>& options = out[command];
    if (options.empty() && has_common_options(command)) options = {{"--json", "FILE"}, {"--quiet", ""}};
    options.push_back({comma == std::string::npos ? names : names.substr(comma + 1),
                            names_end == std::string::npos ? "" : shown.substr(names_end + 1)});
  }
  std::filesystem::remove(path);
  return out;
}

// Words of a short run of each command; one that takes long gets a file that it refuses.
const std::map<std::string, Words>& short_lines() {
  static const std::map<std::string, Words> kLinesOf = {
      {"info", {"planar-2r"}},
      {"check", {"rec.csv"}},
      {"identify", {"planar-2r", "--train", "rec.csv"}},
      {"diagnose", {"planar-2r", "--train", "rec.csv", "--test", "rec.csv"}},
      {"friction", {"planar-2r", "rec.csv"}},
      {"fleet", {"planar-2r", "fleet.txt"}},
      {"payload", {"robot.yaml", "--recording", "rec.csv"}},
      {"calibrate axis", {"table.csv"}},
      {"calibrate rcm", {"table.csv"}},
      {"calibrate links", {"planar-2r", "table.csv"}},
      {"calibrate handeye", {"table.csv", "table.csv"}},
      {"compare", {"robot.yaml", "robot.yaml"}},
      {"export", {"robot.yaml", "--urdf", "out.urdf"}},
      {"excite", {"planar-2r", "--output", "out.csv", "--starts", "1", "--iterations", "2"}},
      {"simulate", {"planar-2r", "--trajectory", "rec.csv", "--output", "out.csv"}},
      {"cooperate", {"scenario.yaml"}},
      {"kinematics", {"planar-2r", "--forward", "0,0"}},
      {"page", {".", "--output", "out.html"}},
      {"numbers", {"watch"}},
      {"loadcell calibrate", {"table.csv", "--output", "out.yaml"}},
      {"loadcell read", {"udp:1", "--seconds", "0.1"}},
      {"stability", {"scenario.yaml"}},
      {"dvrk emulate", {"--arm", "PSM1", "--port", "0", "--seconds", "0.1"}},
      {"dvrk monitor", {"--arm", "PSM1", "--port", "9", "--seconds", "0.1"}},
      {"dvrk read", {"--arm", "PSM1", "--port", "9", "--seconds", "0.1", "--output", "out.csv"}},
      {"dvrk run", {"--arm", "PSM1", "--emulate", "--controller", "pid", "--trajectory", "rec.csv", "--output", "out.csv"}},
      {"dvrk config", {"--arm", "PSM1", "--output", "out.xml"}},
      {"watch", {"robot.yaml", "rec.csv"}},
      {"help", {}},
  };
  return kLinesOf;
}

// Lines of a refused run but its warnings; -1 if one of them is not the tool's own.
long refusals(const std::string& err) {
  std::istringstream lines(err);
  long out = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("veridyn: ", 0) != 0) return -1;
    if (line.rfind("veridyn: warning: ", 0) != 0) ++out;
  }
  return out;
}

class WrongLines : public testing::Test {
 protected:
  WrongLines() {
    folder_.write("rec.csv", planar_recording(3.0));
    folder_.write("fleet.txt", "a,rec.csv\n");
    folder_.write("table.csv", "t,x,y,z\n0,0,0,0\n");
    folder_.write("scenario.yaml", "veridyn: 1\n");
    EXPECT_EQ(run_tool({"export", "planar-2r", "--yaml", folder_.path("robot.yaml"), "--quiet"}).status, 0);
    std::filesystem::create_directory(folder_.path("folder"));
    options_ = options_of_commands(folder_);
    for (const auto& [name, words] : short_lines()) commands_.push_back(name);
    files_ = folder_.files();
  }

  template <typename List>
  const auto& any_of(const List& list) {
    return list[random_() % list.size()];
  }

  // The short line of a command, without an option and its value.
  static Words line_without(const std::string& command, const std::string& option = "") {
    std::istringstream names(command);
    Words out;
    for (std::string word; names >> word;) out.push_back(word);
    const Words& words = short_lines().at(command);
    for (std::size_t k = 0; k < words.size(); ++k) {
      if (words[k] == option) ++k;
      else out.push_back(words[k]);
    }
    if (has_common_options(command) && option != "--quiet") out.push_back("--quiet");
    return out;
  }

  // One of a command's options of a kind; nothing if it has none.
  template <typename Kind>
  const Option* option_of(const std::string& command, Kind kind) {
    std::vector<const Option*> fit;
    for (const Option& option : options_[command])
      if (kind(option)) fit.push_back(&option);
    return fit.empty() ? nullptr : any_of(fit);
  }

  std::string misspelt(const std::string& command) {
    const Option* right = option_of(command, [](const Option&) { return true; });
    std::string name = right == nullptr ? "--quiet" : right->name;
    do name.insert(2 + random_() % (name.size() - 1), 1, static_cast<char>('a' + random_() % 26));
    while (option_of(command, [&](const Option& o) { return o.name == name; }) != nullptr);
    return name;
  }

  // A line with something wrong in it, and what that is; empty if the command has no place for that.
  std::pair<std::string, Words> wrong_line(const std::string& command);

  // Runs a line in the folder. One that is refused has one line, and leaves nothing.
  // @returns its status.
  int run(const std::string& what, const Words& words) {
    const ToolRun run = run_tool(words, folder_.path(""), kLongest);
    std::string line = what + ":";
    for (const std::string& word : words) line += " '" + word + "'";
    EXPECT_GE(run.status, 0) << line << " crashed or did not end";
    EXPECT_NE(run.status, 1) << line << "\n" << run.err;
    if (run.status == 2 || run.status == 3) {
      EXPECT_EQ(refusals(run.err), 1) << line << "\n" << run.err;
      EXPECT_EQ(folder_.files(), files_) << line;
    }
    for (const std::string& name : folder_.files())
      if (std::find(files_.begin(), files_.end(), name) == files_.end()) std::filesystem::remove_all(folder_.path(name));
    if (run.status == 0 || run.status == 4) done_ = line;
    return run.status;
  }

  TemporaryFolder folder_;
  Words files_;
  std::string done_;  // the last line that was not refused
  std::map<std::string, std::vector<Option>> options_;
  std::vector<std::string> commands_;
  std::mt19937 random_{35};
};

std::pair<std::string, Words> WrongLines::wrong_line(const std::string& command) {
  static const Words kNoNumbers = {"nan", "inf", "-inf", "word", "1 2", "0x", "5:2", "--"};
  static const Words kNoFiles = {"missing.csv", "folder", "", "folder/missing.csv"};
  const Words right = line_without(command);
  const auto takes_value = [](const Option& o) { return o.takes_value(); };
  switch (random_() % 9) {
    case 0: return {"an unknown option", right + Words{"--no-" + std::to_string(random_()), "1"}};
    case 1: return {"a misspelt option", right + Words{misspelt(command)}};
    case 2: {
      const Option* option = option_of(command, takes_value);
      if (option == nullptr) return {};
      return {"a missing value", line_without(command, option->name) + Words{option->name}};
    }
    case 3: {
      const Option* option = option_of(command, [](const Option& o) { return o.number(); });
      if (option == nullptr) return {};
      return {"no number", line_without(command, option->name) + Words{option->name + "=" + any_of(kNoNumbers)}};
    }
    case 4: {
      const Option* option = option_of(command, takes_value);
      if (option == nullptr) return {};
      return {"an empty word", line_without(command, option->name) + Words{option->name, ""}};
    }
    case 5: {
      const Option* option = option_of(command, [](const Option& o) { return o.output(); });
      if (option == nullptr) return {};
      return {"an output that cannot be written", line_without(command, option->name) + Words{option->name, any_of(Words{"folder", "no/such/file"})}};
    }
    case 6: {
      const Option* option = option_of(command, [](const Option& o) { return o.once(); });
      if (option == nullptr) return {};
      return {"an option twice", line_without(command, option->name) + Words{option->name, "1", option->name, "1"}};
    }
    case 7: return {"a word too many", right + Words{any_of(kNoFiles)}};
    default: {
      std::vector<std::size_t> inputs;
      for (std::size_t k = 0; k < right.size(); ++k)
        if (std::find(files_.begin(), files_.end(), right[k]) != files_.end() || right[k] == "planar-2r") inputs.push_back(k);
      if (inputs.empty()) return {};
      Words wrong = right;
      wrong[any_of(inputs)] = any_of(kNoFiles);
      return {"an input that is none", wrong};
    }
  }
}

TEST_F(WrongLines, WithInvalidOptionsFailInOneLineAndWriteNothing) {
  for (const auto& [command, options] : options_) {
    const bool of_others = command == "dvrk" || command == "calibrate" || command == "loadcell";
    EXPECT_TRUE(of_others || short_lines().count(command) == 1) << command << " has no right line to start from";
  }
  int lines = 0;
  for (std::size_t k = 0; lines < kLines; ++k) {
    const auto [what, words] = wrong_line(commands_[k % commands_.size()]);
    if (words.empty()) continue;
    const int status = run(what, words);
    EXPECT_TRUE(status == 2 || status == 3) << status << " of " << done_;
    ++lines;
  }
}

// Numbers that some options take and others do not.
TEST_F(WrongLines, WithExtremeNumbersFailInOneLineOrSucceed) {
  static const Words kExtremes = {"1e305", "-1e305", "1e-305", "-1", "0", "99999999999999999999"};
  // A long time is right, and takes long.
  const auto number = [](const Option& o) { return o.number() && o.name != "--seconds"; };
  for (int k = 0; k < kExtremeLines; ++k) {
    const std::string& command = any_of(commands_);
    const Option* const option = option_of(command, number);
    if (option == nullptr) continue;
    run("an extreme number", line_without(command, option->name) + Words{option->name + "=" + any_of(kExtremes)});
  }
}

}  // namespace
}  // namespace veridyn
