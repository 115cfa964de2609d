#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace veridyn::cli {

/// Adds an option whose value is a file to write: check_arguments() keeps it off the inputs.
/// A name that ends as another format does is refused: --json, --report, --urdf, --mjcf, --sdf,
/// --yaml, --coefficients, --model-out and --robot-out know theirs.
/// @param endings  of an option of another name, as ".csv"; none: any.
CLI::Option* add_output_option(CLI::App& command, const std::string& option, std::string& target,
                               const std::string& help, const std::vector<std::string>& endings = {});

/// For inputs that are named in a file rather than as arguments.
/// @throws CLI::ValidationError  the option's file is one of those that are read.
void require_separate_output(const std::string& option, const std::string& output,
                  const std::vector<std::string>& inputs);

/// Checks the arguments of every command, after parsing and before it runs: numbers are finite, no
/// two outputs go to one file, and no output goes over an input. Call it once all commands are
/// there.
///
/// The commands then throw CLI::ValidationError with the name of the option.
void check_arguments(CLI::App& tool);

}  // namespace veridyn::cli
