#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace veridyn::cli {

/// Adds an option whose value is a file to write; check_arguments() refuses one that would overwrite an input.
/// A file name with the ending of another format is refused: --json, --report, --urdf, --mjcf, --sdf, --yaml,
/// --coefficients, --model-out and --robot-out have theirs.
/// @param endings  allowed ones of any other option, such as ".csv"; empty: all.
CLI::Option* add_output_option(CLI::App& command, const std::string& option, std::string& target,
                               const std::string& help, const std::vector<std::string>& endings = {});

/// Checks an option against inputs that are named in a file rather than as arguments.
/// @throws CLI::ValidationError  the option's file is one of those that are read.
void require_separate_output(const std::string& option, const std::string& output,
                  const std::vector<std::string>& inputs);

/// Checks the arguments of every command, after parsing and before it runs: numbers are finite, no two outputs
/// go to one file, and no output overwrites an input. Call it once all commands have been added. The commands
/// then throw CLI::ValidationError with the name of the option.
void check_arguments(CLI::App& tool);

}  // namespace veridyn::cli
