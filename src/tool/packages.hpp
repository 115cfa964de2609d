#pragma once

#include <string>
#include <vector>

#include "tool/manual.hpp"

namespace veridyn::cli {

/// A command that the program of a package runs.
struct PackageCommand {
  std::string command;  ///< command of `veridyn`
  std::string package, program;
  std::string summary;  ///< text for the list of commands; empty: it extends a library command
  std::vector<std::string> words;  ///< arguments by which a call of such a command belongs to the package
};

/// All commands of packages. `veridyn` starts only programs of this list.
const std::vector<PackageCommand>& package_commands();

/// Runs the program of a package in place of this one, if the call belongs to a package.
/// @param arguments  arguments of `veridyn`.
/// @returns  a status if the package is not installed; nullopt if the call belongs to the library; does not
/// return if the program starts.
std::optional<int> pass_to_package(const std::vector<std::string>& arguments);

/// Help of the commands of a program; empty if it is not installed.
std::vector<CommandHelp> help_of_program(const std::string& program);

}  // namespace veridyn::cli
