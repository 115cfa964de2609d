#include "tool/examples.hpp"

#include <map>

#include "veridyn/tool/program.hpp"

namespace veridyn::cli {
namespace {

// tests/cli/manual_test.cpp runs these in order, in a folder with the results of the earlier ones, except
// those that need boards, a sensor or recordings of a camera.
std::map<std::string, std::vector<ManualPage::Entry>>& examples() {
  static std::map<std::string, std::vector<ManualPage::Entry>> all = {
      {"veridyn", {{"veridyn help identify", "Show the options and examples of one command"}}},
      {"veridyn help",
       {{"veridyn help dvrk run", "Show the options and examples of a command within another"},
        {"veridyn help --bash veridyn.bash",
         "Write completion for bash, which `source veridyn.bash` turns on"}}},
      {"veridyn excite",
       {{"veridyn excite psm-3dof -o motion.csv --report motion.html",
         "Design a trajectory that starts and ends at rest, and look at it"},
        {"veridyn excite psm-3dof --criterion condition --starts 1 --seed 7 -o other.csv",
         "Minimise the regressor's condition number instead"}}},
      {"veridyn simulate",
       {{"veridyn simulate psm-3dof --trajectory motion.csv -o one.csv --arm-seed 4",
         "Record a simulated arm along a trajectory"},
        {"veridyn simulate psm-3dof --trajectory other.csv -o two.csv --arm-seed 4 --seed 2",
         "The same arm along another trajectory"},
        {"veridyn simulate psm-3dof --trajectory other.csv -o loaded.csv --arm-seed 4 --seed 3 "
         "--effect payload:counterweight:mass=0.2",
         "The same arm with a load that the robot file does not have"}}},
      {"veridyn check",
       {{"veridyn check one.csv", "Report gaps, duplicated samples and noise of a recording"},
        {"veridyn check psm-3dof one.csv two.csv",
         "Also compare units, signs and joint order with a robot file"}}},
      {"veridyn identify",
       {{"veridyn identify psm-3dof --train one.csv --model-out model.yaml",
         "Identify a physically consistent model and keep it"},
        {"veridyn identify psm-3dof --train two.csv --test one.csv --model-out later.yaml --report "
         "identify.html",
         "Validate on a recording that took no part, with plots"}}},
      {"veridyn diagnose",
       {{"veridyn diagnose psm-3dof --train one.csv --test two.csv --report diagnosis.html",
         "Identify, then name what the model lacks"},
        {"veridyn diagnose model.yaml --train loaded.csv --rows :4000 --test loaded.csv "
         "--test-rows "
         "4000: --model-out today.yaml",
         "Name what changed since a model was identified; one recording is split here"}}},
      {"veridyn friction",
       {{"veridyn friction psm-3dof one.csv", "Friction torque of every joint against its speed"},
        {"veridyn friction psm-3dof one.csv --report friction.html --json friction.json",
         "The same as a page with curves, and as numbers"}}},
      {"veridyn payload",
       {{"veridyn payload model.yaml --recording loaded.csv",
         "Find the load of a recording, for each link that might carry it"},
        {"veridyn payload model.yaml --recording loaded.csv --link counterweight",
         "Only as a load of one link"}}},
      {"veridyn compare",
       {{"veridyn compare model.yaml later.yaml",
         "Which parameters differ beyond chance, and by how much torque"},
        {"veridyn compare model.yaml later.yaml --significance 0.01 --report compare.html",
         "With a stricter level, as a page"}}},
      {"veridyn export",
       {{"veridyn export model.yaml --urdf arm.urdf --mjcf arm.xml",
         "Write the model for other simulators"},
        {"veridyn export model.yaml --c arm.h",
         "Write inverse dynamics, regressor and friction as C without dependencies"}}},
      {"veridyn info",
       {{"veridyn info psm-3dof",
         "Joints, frames, effects and identifiable parameters of a robot file"},
        {"veridyn info arm.urdf --yaml arm.yaml",
         "Turn a URDF into a robot file to continue with"}}},
      {"veridyn kinematics",
       {{"veridyn kinematics ur10e --forward 0,-1.2,1.5,-0.3,0.5,0",
         "Pose of the last frame for one set of joint positions"},
        {"veridyn kinematics ur10e --workspace 500",
         "Conditioning of 500 postures within the joint limits"}}},
      {"veridyn watch",
       {{"veridyn watch model.yaml two.csv loaded.csv --report watch.html",
         "Detect a change from one recording to the next"},
        {"veridyn watch model.yaml two.csv loaded.csv --json-lines --quiet",
         "Print every event as one line of JSON; with --follow, of a file that grows"}}},
      {"veridyn fleet",
       {{"veridyn fleet psm-3dof fleet.txt",
         "A common model of the recordings listed in fleet.txt, each line an arm's name and its "
         "recordings"},
        {"veridyn fleet psm-3dof fleet.txt --model-out common.yaml", "Keep the common model"}}},
      {"veridyn page",
       {{"veridyn page . -o index.html", "Gather the models and pages of this folder"},
        {"veridyn page . -o index.html --json index.json", "The same, with its numbers"}}},
      {"veridyn numbers",
       {{"veridyn numbers diagnose", "Numbers that decide a diagnosis, with their reasons"},
        {"veridyn numbers search", "Those of the one search"}}},
  };
  return all;
}

}  // namespace

void add_examples(const std::string& command, const std::vector<Example>& added) {
  std::vector<ManualPage::Entry>& all = examples()[command];
  all.clear();
  for (const Example& one : added) all.push_back({one.command_line, one.purpose});
}

std::vector<ManualPage::Entry> examples_of(const std::string& command) {
  const auto found = examples().find(command);
  return found == examples().end() ? std::vector<ManualPage::Entry>{} : found->second;
}

}  // namespace veridyn::cli
