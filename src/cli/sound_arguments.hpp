#pragma once

#include <CLI/CLI.hpp>

namespace veridyn::cli {

/// Looks at what every command was given, after parsing and before it runs: numbers are finite, no
/// two outputs go to one file, and no output goes over an input. Call it once all commands are
/// there.
///
/// The commands then throw CLI::ValidationError with the name of the option.
void expect_sound_arguments(CLI::App& tool);

}  // namespace veridyn::cli
