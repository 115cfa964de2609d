// tool/: options, messages and help of the command line, shared with the programs of packages.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

namespace veridyn::cli {

/// Exit status of the tool; scripts rely on the numbers, which never change.
enum ExitStatus {
  kDone = 0,
  kProgramFault = 1,
  kWrongUsage = 2,
  kBadInput = 3,
  kDataCannotAnswer = 4,
  kInterrupted = 130,  ///< Ctrl-C ended the work early; files that were written are complete
};

/// Result of the command that ran. A command that returns normally is done; bad input and wrong
/// usage are exceptions (InvalidInput, CLI::ParseError), which run_tool() maps to a status.
struct Outcome {
  ExitStatus status = kDone;
  std::string command_line;  ///< command line of the user, quoted for a shell; set from the start
};

/// Adds a subcommand with its options and a callback that does the work and sets the outcome.
using AddCommand = std::function<void(CLI::App& tool, Outcome& outcome)>;

/// A line of a command's manual that a reader can copy.
struct Example {
  std::string command_line, purpose;
};

/// Adds examples to the manual of a command. @param command  full name, such as "veridyn dvrk run".
void add_examples(const std::string& command, const std::vector<Example>& examples);

/// Names a command of a package in the list of commands. It is never run: run_tool() hands it over to the package's program.
AddCommand package_command(const std::string& command);

/// Runs `veridyn` with these commands and `help`; errors become one line on standard error and a status. A command of a package is
/// looked for beside the running program, then on the path, as `veridyn-COMMAND`.
int run_tool(const std::vector<AddCommand>& commands, int argc, char** argv);

/// Runs the program of a package, `veridyn-COMMAND ...` for `veridyn COMMAND ...`. As its first argument it takes
/// `--as COMMAND`, where one program has several commands, and `--describe`, which prints the help of
/// all of them as JSON for `veridyn help`.
int run_package(const std::vector<AddCommand>& commands, int argc, char** argv);

}  // namespace veridyn::cli
