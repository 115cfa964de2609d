#pragma once

#include <string>
#include <vector>

#include "tool/manual.hpp"

namespace veridyn::cli {

/// Command lines that show a command at work, each with its purpose.
/// @param command  full name, such as `veridyn dvrk run`; the result for an unknown one is empty
std::vector<ManualPage::Entry> examples_of(const std::string& command);

}  // namespace veridyn::cli
