#include "cli/cooperation/commands.hpp"

using namespace veridyn::cli;

int main(int argc, char** argv) {
  add_examples("veridyn cooperate",
               {{"veridyn cooperate examples/cooperate/two-arms-spring.yaml -o rows.csv",
                "Simulate two arms that hold one object"},
                {"veridyn cooperate examples/dvrk/two-psm-spring.yaml --boards PSM1 PSM2 --emulate "
                "--stepped",
                "Run a scenario on emulated dVRK boards"}});
  add_examples("veridyn stability",
               {{"veridyn stability examples/cooperate/two-arms-spring.yaml",
                "Eigenvalues and margins of a scenario's force loop"},
                {"veridyn stability examples/cooperate/two-arms-spring.yaml --recommend 45",
                "Gains with a phase margin of 45 degrees"}});
  add_examples("veridyn loadcell calibrate",
               {{"veridyn loadcell calibrate readings.csv -o cell.yaml",
                "Offset and scale from known weights"}});
  add_examples("veridyn loadcell read",
               {{"veridyn loadcell read udp:5000 --calibration cell.yaml --seconds 10",
                "Show forces and whether the sensor is alive"}});
  return run_package({add_cooperate_command, add_stability_command, add_loadcell_command}, argc, argv);
}
