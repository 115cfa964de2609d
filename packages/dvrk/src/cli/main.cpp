#include "cli/boards/dvrk_request.hpp"
#include "cli/models/arm_kinematics.hpp"
#include "cli/models/export_dvrk.hpp"

using namespace veridyn::cli;

int main(int argc, char** argv) {
  add_examples("veridyn dvrk emulate",
               {{"veridyn dvrk emulate --arm PSM1 --model examples/dvrk/light-psm.yaml --config-out io.xml",
                "Emulate the boards of one arm with simulated dynamics until Ctrl-C"}});
  add_examples("veridyn dvrk monitor",
               {{"veridyn dvrk monitor --config io.xml --seconds 2", "Show joints, currents and faults"}});
  add_examples("veridyn dvrk read",
               {{"veridyn dvrk read --config io.xml --seconds 30 -o rec.csv",
                "Record an arm that another program drives"}});
  add_examples("veridyn dvrk run",
               {{"veridyn dvrk run --arm PSM1 --model examples/dvrk/light-psm.yaml --controller "
                "computed-torque --trajectory traj.csv -o rec.csv --emulate",
                "Follow a trajectory on emulated boards; without --emulate, on the boards of a real "
                "arm"}});
  add_examples("veridyn dvrk config",
               {{"veridyn dvrk config --arm PSM1 -o io.json",
                "Write the nominal configuration of an arm"}});
  const auto add_export = [](CLI::App& tool, Outcome& outcome) { add_export_command(tool, outcome, export_dvrk()); };
  const auto add_kinematics = [](CLI::App& tool, Outcome& outcome) { add_kinematics_command(tool, outcome, dvrk_kinematics()); };
  return run_package({add_dvrk_command, add_export, add_kinematics}, argc, argv);
}
