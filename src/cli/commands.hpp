#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace veridyn::cli {

/// Exit status of the tool; the numbers are a promise to scripts.
enum ExitStatus {
  kDone = 0,
  kProgramFault = 1,
  kWrongUsage = 2,
  kBadInput = 3,
  kDataCannotAnswer = 4,
  kInterrupted = 130,  ///< Ctrl-C ended the work before its end; what was written is whole
};

/// Result of the command that ran. A command that returns normally is done; bad input and wrong
/// usage are exceptions (InvalidInput, CLI::ParseError), which main.cpp maps to a status.
struct Outcome {
  ExitStatus status = kDone;
  std::string command_line;  ///< command line of the user, quoted for a shell; set from the start
};

// One per command, each in its own file `NAME_command.cpp`: adds the subcommand with its options
// and a callback that does the work and sets the outcome. A new command needs a line here, one in
// main.cpp and one in CMakeLists.txt.

void add_info_command(CLI::App& tool, Outcome& outcome);
void add_calibrate_command(CLI::App& tool, Outcome& outcome);
void add_compare_command(CLI::App& tool, Outcome& outcome);
void add_check_command(CLI::App& tool, Outcome& outcome);
void add_identify_command(CLI::App& tool, Outcome& outcome);
void add_fleet_command(CLI::App& tool, Outcome& outcome);
void add_diagnose_command(CLI::App& tool, Outcome& outcome);
void add_friction_command(CLI::App& tool, Outcome& outcome);
void add_numbers_command(CLI::App& tool);
void add_page_command(CLI::App& tool, Outcome& outcome);
void add_payload_command(CLI::App& tool, Outcome& outcome);
void add_export_command(CLI::App& tool, Outcome& outcome);
void add_excite_command(CLI::App& tool, Outcome& outcome);
void add_simulate_command(CLI::App& tool, Outcome& outcome);
void add_cooperate_command(CLI::App& tool, Outcome& outcome);
void add_kinematics_command(CLI::App& tool, Outcome& outcome);
void add_loadcell_command(CLI::App& tool, Outcome& outcome);
void add_stability_command(CLI::App& tool, Outcome& outcome);
void add_dvrk_command(CLI::App& tool, Outcome& outcome);
void add_watch_command(CLI::App& tool, Outcome& outcome);

}  // namespace veridyn::cli
