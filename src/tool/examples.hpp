#pragma once

#include <string>
#include <vector>

#include "tool/manual.hpp"

namespace veridyn::cli {

/// Command lines that show a command at work, each with its purpose.
/// @param command  in full, as `veridyn dvrk run`; empty for an unknown one
std::vector<ManualPage::Entry> examples_of(const std::string& command);

}  // namespace veridyn::cli
