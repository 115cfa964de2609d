#include <fcntl.h>
#include <unistd.h>

#include <exception>
#include <iostream>
#include <new>
#include <string>

#include "cli/commands.hpp"
#include "cli/help/manual.hpp"
#include "cli/help/usage.hpp"
#include "cli/options/messages.hpp"
#include "cli/options/sound_arguments.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::cli {
namespace {

ExitStatus run(int argc, char** argv) {
  CLI::App tool("Identify, diagnose, simulate and control robot arms with measured dynamics",
                "veridyn");
  show_manual_as_help(tool);
  tool.set_version_flag("--version", "veridyn " VERIDYN_VERSION);
  tool.require_subcommand(1);
  Outcome outcome;
  outcome.command_line = command_line(argc, argv);
  add_info_command(tool, outcome);
  add_check_command(tool, outcome);
  add_identify_command(tool, outcome);
  add_diagnose_command(tool, outcome);
  add_friction_command(tool, outcome);
  add_fleet_command(tool, outcome);
  add_payload_command(tool, outcome);
  add_calibrate_command(tool, outcome);
  add_compare_command(tool, outcome);
  add_export_command(tool, outcome);
  add_excite_command(tool, outcome);
  add_simulate_command(tool, outcome);
  add_cooperate_command(tool, outcome);
  add_kinematics_command(tool, outcome);
  add_page_command(tool, outcome);
  add_numbers_command(tool);
  add_loadcell_command(tool, outcome);
  add_stability_command(tool, outcome);
  add_dvrk_command(tool, outcome);
  add_watch_command(tool, outcome);
  add_help_command(tool);
  expect_sound_arguments(tool);
  try {
    tool.parse(argc, argv);
    return outcome.status;
  } catch (const CLI::Success& help_or_version) {
    tool.exit(help_or_version);
    return kDone;
  } catch (const CLI::ParseError& error) {
    say(usage_message(tool, error));
    return kWrongUsage;
  }
}

ExitStatus run_and_explain(int argc, char** argv) {
  try {
    const ExitStatus status = run(argc, argv);
    require(static_cast<bool>(std::cout.flush()), "standard output: writing failed.");
    return status;
  } catch (const InvalidInput& error) {
    say(error.what());
    // An error that begins with an option is a bad value of that option, detected where it is used.
    return std::string(error.what()).rfind("--", 0) == 0 ? kWrongUsage : kBadInput;
  } catch (const std::bad_alloc&) {
    say("out of memory.");
    return kProgramFault;
  } catch (const std::exception& error) {
    say(std::string("internal fault: ") + error.what());
    return kProgramFault;
  }
}

// Where a standard stream is closed, the first file that is opened would get its number, and with it the messages
// for that stream. The null device takes the place, opened so that using it fails as before.
void hold_places_of_closed_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(stream, F_GETFD) < 0) ::open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
  }
}

}  // namespace
}  // namespace veridyn::cli

int main(int argc, char** argv) {
  veridyn::cli::hold_places_of_closed_streams();
  return veridyn::cli::run_and_explain(argc, argv);
}
