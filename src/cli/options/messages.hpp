#pragma once

#include <functional>
#include <string>
#include <vector>

#include "cli/options/common_options.hpp"

namespace veridyn::cli {

/// Prints `veridyn: line` on standard error, and clears a progress bar there.
void say(const std::string& line);

/// The arguments as one line that a shell parses into the same arguments.
std::string command_line(int argc, const char* const* argv);

std::string command_line(const std::vector<std::string>& words);

/// Called with the current activity and the share done, 0 to 1.
using Progress = std::function<void(const std::string&, double)>;

/// A progress bar if standard error is a terminal, otherwise a plain line per activity; empty with
/// --quiet.
Progress progress(const CommonOptions& options);

}  // namespace veridyn::cli
