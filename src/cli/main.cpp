#include "cli/commands.hpp"
#include "veridyn/tool/open_commands.hpp"

int main(int argc, char** argv) {
  using namespace veridyn::cli;
  const auto add_export = [](CLI::App& tool, Outcome& outcome) { add_export_command(tool, outcome, {}); };
  const auto add_excite = [](CLI::App& tool, Outcome& outcome) { add_excite_command(tool, outcome, {}); };
  const auto add_kinematics = [](CLI::App& tool, Outcome& outcome) { add_kinematics_command(tool, outcome, {}); };
  const auto add_numbers = [](CLI::App& tool, Outcome&) { add_numbers_command(tool); };
  // Commands in the order of the manual.
  return run_tool({add_info_command, add_check_command, add_identify_command, add_diagnose_command,
                   add_friction_command, add_fleet_command, add_payload_command, package_command("calibrate"),
                   add_compare_command, add_export, add_excite, add_simulate_command, package_command("cooperate"),
                   add_kinematics, add_page_command, add_numbers, package_command("loadcell"), package_command("stability"),
                   package_command("dvrk"), add_watch_command},
                  argc, argv);
}
