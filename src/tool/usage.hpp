#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace veridyn::cli {

/// The error in the command line as one line, with a suggestion for a misspelt word.
std::string usage_message(const CLI::App& tool, const CLI::ParseError& error);

}  // namespace veridyn::cli
