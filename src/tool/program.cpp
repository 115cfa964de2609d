#include "veridyn/tool/program.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <exception>
#include <iostream>
#include <new>

#include "tool/manual.hpp"
#include "tool/packages.hpp"
#include "tool/usage.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/tool/messages.hpp"
#include "veridyn/tool/sound_arguments.hpp"

namespace veridyn::cli {
namespace {

using Words = std::vector<std::string>;

void add_all(const std::vector<AddCommand>& commands, CLI::App& tool, Outcome& outcome) {
  show_manual_as_help(tool);
  tool.set_version_flag("--version", "veridyn " VERIDYN_VERSION);
  tool.require_subcommand(1);
  for (const AddCommand& add : commands) add(tool, outcome);
}

int run(const std::vector<AddCommand>& commands, const Words& words) {
  CLI::App tool("Identify, diagnose, simulate and control robot arms with measured dynamics", "veridyn");
  Outcome outcome;
  outcome.command_line = command_line(Words{"veridyn"}) + (words.empty() ? "" : " " + command_line(words));
  add_all(commands, tool, outcome);
  check_arguments(tool);
  try {
    tool.parse(Words(words.rbegin(), words.rend()));
    return outcome.status;
  } catch (const CLI::Success& help_or_version) {
    tool.exit(help_or_version);
    return kDone;
  } catch (const CLI::ParseError& error) {
    print_message(usage_message(tool, error));
    return kWrongUsage;
  }
}

template <typename Work>
int run_and_report_errors(const Work& work) {
  try {
    const int status = work();
    require(static_cast<bool>(std::cout.flush()), "standard output: writing failed.");
    return status;
  } catch (const InvalidInput& error) {
    print_message(with_registered_reason(error.what()));
    // An error that begins with an option is reported as wrong usage: its value was refused after parsing.
    return std::string(error.what()).rfind("--", 0) == 0 ? kWrongUsage : kBadInput;
  } catch (const std::bad_alloc&) {
    print_message("out of memory.");
    return kProgramFault;
  } catch (const std::exception& error) {
    print_message(std::string("internal fault: ") + error.what());
    return kProgramFault;
  }
}

// Opens the null device in place of a closed standard stream. Otherwise the next file to be opened would get
// its number and receive the messages for that stream.
void open_null_for_closed_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(stream, F_GETFD) < 0) ::open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
  }
}

// Handles SIGBUS: a large recording is mapped into memory, and access to pages that another program has
// truncated is a fault.
void handle_truncated_files() {
  struct sigaction action {};
  action.sa_handler = [](int) {
    static constexpr char kWords[] = "veridyn: found a recording that another program cut while it was read, expected one that stays.\n";
    const ssize_t written = ::write(STDERR_FILENO, kWords, sizeof kWords - 1);
    ::_exit(written < 0 ? kProgramFault : kBadInput);
  };
  ::sigaction(SIGBUS, &action, nullptr);
}

// The command of a program from its path: "cooperate" for ".../veridyn-cooperate".
std::string command_of(const std::string& program) {
  const std::string name = program.substr(program.rfind('/') + 1);
  return name.substr(name.find('-') + 1);
}

int describe(const std::vector<AddCommand>& commands) {
  CLI::App tool("", "veridyn");
  Outcome outcome;
  add_all(commands, tool, outcome);
  std::cout << to_json(help_of(tool));
  return kDone;
}

}  // namespace

AddCommand package_command(const std::string& command) {
  for (const PackageCommand& row : package_commands()) {
    if (row.command == command) return [&row](CLI::App& tool, Outcome&) { tool.add_subcommand(row.command, row.summary); };
  }
  throw InvalidInput("found the command '" + command + "', expected one of a package.");
}

int run_tool(const std::vector<AddCommand>& commands, int argc, char** argv) {
  open_null_for_closed_streams();
  handle_truncated_files();
  return run_and_report_errors([&] {
    const Words words(argv + std::min(argc, 1), argv + argc);
    if (const std::optional<int> status = pass_to_package(words)) return *status;
    std::vector<AddCommand> all = commands;
    all.emplace_back([](CLI::App& tool, Outcome&) { add_help_command(tool); });
    return run(all, words);
  });
}

int run_package(const std::vector<AddCommand>& commands, int argc, char** argv) {
  open_null_for_closed_streams();
  handle_truncated_files();
  return run_and_report_errors([&] {
    Words words(argv + std::min(argc, 1), argv + argc);
    if (words == Words{"--describe"}) return describe(commands);
    if (!words.empty() && words.front() == "--as") {
      words.erase(words.begin());
    } else {
      words.insert(words.begin(), command_of(argc > 0 ? argv[0] : ""));
    }
    if (words.back() == "--version") words = {"--version"};  // the package's version, also for subcommands
    return run(commands, words);
  });
}

}  // namespace veridyn::cli
