#pragma once

#include <functional>
#include <string>
#include <vector>

#include "cli/options/common_options.hpp"

namespace veridyn::cli {

/// `veridyn: line` on standard error, in place of a progress bar if one stands there.
void say(const std::string& line);

/// The words as one line that a shell reads as these words again.
std::string command_line(int argc, const char* const* argv);

std::string command_line(const std::vector<std::string>& words);

/// Called with what is being done and the share that is done, 0 to 1.
using Progress = std::function<void(const std::string&, double)>;

/// A bar where standard error is a terminal, otherwise a plain line for every new thing done; empty
/// with --quiet.
Progress progress(const CommonOptions& options);

}  // namespace veridyn::cli
