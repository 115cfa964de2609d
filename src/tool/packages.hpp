#pragma once

#include <string>
#include <vector>

#include "tool/manual.hpp"

namespace veridyn::cli {

/// A command that the program of a package runs.
struct PackageCommand {
  std::string command;  ///< of `veridyn`
  std::string package, program;
  std::string summary;  ///< for the list of commands; empty: a command of the library to which the package adds
  std::vector<std::string> words;  ///< arguments by which a call of such a command is the package's
};

/// All commands of packages. `veridyn` starts programs of this list and no others.
const std::vector<PackageCommand>& package_commands();

/// Hands the call over to the program of a package, if it is one's.
/// @param arguments  behind `veridyn`.
/// @returns  a status if the package is not there; does not return if it is; nullopt: the call is the library's.
std::optional<int> pass_to_package(const std::vector<std::string>& arguments);

/// Help of the commands of a program; empty where it is not installed.
std::vector<CommandHelp> help_of_program(const std::string& program);

}  // namespace veridyn::cli
