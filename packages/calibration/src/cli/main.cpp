#include "cli/calibration/calibrate_options.hpp"
#include "cli/motions/excite_poses.hpp"

using namespace veridyn::cli;

int main(int argc, char** argv) {
  add_examples("veridyn calibrate axis",
               {{"veridyn calibrate axis markers.csv",
                "Axes of rotation between all bodies with markers"}});
  add_examples("veridyn calibrate rcm",
               {{"veridyn calibrate rcm poses.csv --unit mm",
                "Remote centre of motion from poses of the instrument"}});
  add_examples("veridyn calibrate links",
               {{"veridyn calibrate links psm-3dof poses.csv --frame counterweight --robot-out "
                "calibrated.yaml",
                "Correct the constants of a robot file with measured poses"}});
  add_examples("veridyn calibrate handeye",
               {{"veridyn calibrate handeye arm.csv camera.csv",
                "Pose between two arms, or between an arm and a camera"}});
  const auto excite = [](CLI::App& tool, Outcome& outcome) { add_excite_command(tool, outcome, excite_poses()); };
  return run_package({add_calibrate_command, excite}, argc, argv);
}
