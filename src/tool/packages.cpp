#include "tool/packages.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <sstream>

#include "veridyn/model/suggestion.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/tool/messages.hpp"
#include "veridyn/tool/program.hpp"

namespace veridyn::cli {
namespace {

namespace fs = std::filesystem;

bool is_executable(const fs::path& file) {
  std::error_code error;
  return fs::is_regular_file(file, error) && ::access(file.c_str(), X_OK) == 0;
}

// Path of a program: in the folder of the running one, else on PATH; empty if not found.
std::string found_program(const std::string& name) {
  std::error_code unknown;
  const fs::path beside = fs::read_symlink("/proc/self/exe", unknown).parent_path() / name;
  if (!unknown && is_executable(beside)) return beside.string();
  const char* const path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (!folder.empty() && is_executable(fs::path(folder) / name)) return (fs::path(folder) / name).string();
  }
  return {};
}

bool is_help(const std::string& argument) {
  return argument == "--help" || argument == "-h";
}

// True if an argument is "--option" or "--option=value"; the word "--begin-" matches all options that begin
// with it.
bool matches(const std::string& argument, const std::string& word) {
  if (argument.rfind(word, 0) != 0) return false;
  return argument.size() == word.size() || word.back() == '-' || argument[word.size()] == '=';
}

// The first argument that makes the call one of the package; empty if there is none.
std::string matching_argument(const PackageCommand& row, const std::vector<std::string>& arguments) {
  for (std::size_t k = 1; k < arguments.size(); ++k) {
    for (const std::string& word : row.words)
      if (matches(arguments[k], word)) return arguments[k].substr(0, arguments[k].find('='));
  }
  return {};
}

[[noreturn]] void replace_process(const std::string& program, const std::vector<std::string>& arguments) {
  std::vector<std::string> words = {program, "--as"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  ::execv(program.c_str(), argv.data());
  throw InvalidInput(program + ": found a program that cannot be started, expected that of a package.");
}

}  // namespace

const std::vector<PackageCommand>& package_commands() {
  static const std::vector<PackageCommand> kAll = {
      {"calibrate", "calibration", "veridyn-calibrate", "Kinematic calibration: axes, remote centre, links, hand-eye", {}},
      {"cooperate", "cooperation", "veridyn-cooperate",
       "Control arms that hold one object, simulated or on dVRK boards", {}},
      {"stability", "cooperation", "veridyn-stability",
       "Linear stability of a cooperation loop: eigenvalues, margins, maps", {}},
      {"loadcell", "cooperation", "veridyn-loadcell", "Calibrate and read force sensors", {}},
      {"dvrk", "dvrk", "veridyn-dvrk", "Drive, monitor or emulate boards of a da Vinci Research Kit", {}},
      {"excite", "calibration", "veridyn-calibrate", "", {"--for", "--poses", "--frame"}},
      {"export", "dvrk", "veridyn-dvrk", "", {"--dvrk-", "--static-torques"}},
      {"kinematics", "dvrk", "veridyn-dvrk", "", {"PSM1", "PSM2", "PSM3", "MTML", "MTMR", "ECM"}}};
  return kAll;
}

namespace {

std::vector<std::string> commands_below(const PackageCommand& row) {
  for (const CommandHelp& help : help_of_program(row.program)) {
    if (help.page.name == std::string("veridyn ") + row.command) return help.commands;
  }
  return {};
}

}  // namespace

std::optional<int> pass_to_package(const std::vector<std::string>& arguments) {
  if (arguments.empty()) return std::nullopt;
  // Turns `help COMMAND...` into `COMMAND... --help`.
  std::vector<std::string> call = arguments;
  const bool written = std::any_of(call.begin(), call.end(), [](const std::string& word) { return word.rfind("--", 0) == 0; });
  if (call.front() == "help" && call.size() > 1 && !written) {
    call.erase(call.begin());
    call.push_back("--help");
  }
  for (const PackageCommand& row : package_commands()) {
    if (call.front() != row.command) continue;
    const bool extended = row.summary.empty();
    const std::string word = extended ? matching_argument(row, call) : "";
    const bool help = extended && word.empty() && std::any_of(call.begin(), call.end(), is_help);
    if (extended && word.empty() && !help) continue;
    const std::string program = found_program(row.program);
    if (!program.empty() && arguments.front() == "help" && arguments.size() > 2) {
      const std::vector<std::string> below = commands_below(row);
      if (std::find(below.begin(), below.end(), arguments[2]) == below.end()) {
        print_message("found '" + arguments[2] + "', expected " + (below.empty() ? "nothing after '" + arguments[1] + "'" : "one of " + listed(below) + did_you_mean(arguments[2], below)));
        return kWrongUsage;
      }
    }
    if (!program.empty()) replace_process(program, call);
    if (help) continue;
    print_message("'" + row.command + (word.empty() ? "" : " " + word) + "' needs the package " + row.package + ": found no program " +
        row.program + " beside veridyn or on the path; build it with `make all`, or install the package.");
    return kWrongUsage;
  }
  return std::nullopt;
}

std::vector<CommandHelp> help_of_program(const std::string& program) {
  const std::string path = found_program(program);
  if (path.empty()) return {};
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pipe(::popen((command_line({path}) + " --describe").c_str(), "r"), ::pclose);
  require(pipe != nullptr, path, ": cannot be started.");
  std::string text;
  char piece[4096];
  for (std::size_t read = 0; (read = std::fread(piece, 1, sizeof piece, pipe.get())) > 0;) text.append(piece, read);
  return help_from_json(text, path);
}

}  // namespace veridyn::cli
