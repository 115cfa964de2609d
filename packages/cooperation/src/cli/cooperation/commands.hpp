#pragma once

#include "veridyn/tool/program.hpp"

namespace veridyn::cli {

void add_cooperate_command(CLI::App& tool, Outcome& outcome);
void add_stability_command(CLI::App& tool, Outcome& outcome);
void add_loadcell_command(CLI::App& tool, Outcome& outcome);

}  // namespace veridyn::cli
