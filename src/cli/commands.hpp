// cli/: the commands of `veridyn`, one file each.
#pragma once

#include "veridyn/tool/program.hpp"

namespace veridyn::cli {

// Every command has one function, in its own file `NAME_command.cpp`, which adds the subcommand with its
// options and a callback that runs the command and sets the outcome. A new command needs a line here, one in
// main.cpp and one in CMakeLists.txt.

void add_info_command(CLI::App& tool, Outcome& outcome);
void add_compare_command(CLI::App& tool, Outcome& outcome);
void add_check_command(CLI::App& tool, Outcome& outcome);
void add_identify_command(CLI::App& tool, Outcome& outcome);
void add_fleet_command(CLI::App& tool, Outcome& outcome);
void add_diagnose_command(CLI::App& tool, Outcome& outcome);
void add_friction_command(CLI::App& tool, Outcome& outcome);
void add_numbers_command(CLI::App& tool);
void add_page_command(CLI::App& tool, Outcome& outcome);
void add_payload_command(CLI::App& tool, Outcome& outcome);
void add_simulate_command(CLI::App& tool, Outcome& outcome);
void add_watch_command(CLI::App& tool, Outcome& outcome);

}  // namespace veridyn::cli
