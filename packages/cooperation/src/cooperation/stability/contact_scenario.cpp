#include <filesystem>
#include <fstream>

#include "cooperation/scenario/scenario_parts.hpp"
#include "veridyn/cooperation/stability.hpp"
#include "veridyn/kinematics/motion_limits.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

// True if a line of the file begins with the key that every scenario has.
bool is_scenario(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  while (std::getline(file, line)) {
    if (line.rfind("scenario:", 0) == 0) return true;
  }
  return false;
}

// "tool" if the model has it, else its last frame.
std::string touching_frame(const Model& model) {
  return model.find_frame("tool") ? "tool" : model.frames().back().name;
}

}  // namespace

Scenario contact_scenario(const std::string& path, const StabilityModelOptions& options) {
  const Model model = read_model(path);
  Scenario s;
  s.name = model.name() + " against a wall";
  ScenarioArm arm;
  arm.name = model.name();
  arm.model = path;
  arm.frame = options.frame.empty() ? touching_frame(model) : options.frame;
  const MotionLimits limits = motion_limits(model);
  arm.start = 0.5 * (limits.lower + limits.upper);
  if (!options.pose.empty()) {
    arm.start = Eigen::Map<const VectorXd>(options.pose.data(),
                                           static_cast<Eigen::Index>(options.pose.size()));
  }
  check_arm(arm, model);
  s.arms.push_back(arm);
  ScenarioWall wall;
  wall.name = "wall";
  wall.normal = Eigen::Vector3d::UnitX();
  wall.stiffness = options.stiffness;
  wall.damping = options.damping;
  wall.sensor.rate = 500.0;
  wall.sensor.delay = 0.002;
  s.walls.push_back(wall);
  ScenarioPhase phase;
  phase.name = "contact";
  phase.duration = 2.0;
  ScenarioCommand press;
  press.kind = ScenarioCommand::Kind::kMove;
  press.way = {-0.01, 0.0, 0.0};
  press.over = 1.0;
  phase.commands.push_back(press);
  s.phases.push_back(phase);
  return s;
}

Scenario read_scenario_or_model(const std::string& path, const StabilityModelOptions& options) {
  std::error_code ignored;
  if (std::filesystem::is_regular_file(path, ignored) && is_scenario(path)) {
    require(options.frame.empty() && options.pose.empty(), path,
            ": found a scenario, expected a MODEL beside a frame or a pose.");
    return read_scenario(path);
  }
  const std::string file = robot_path(path);
  require(std::filesystem::is_regular_file(file, ignored), path,
          std::filesystem::is_directory(file, ignored) ? ": found a folder" : ": found no such file",
          ", expected a scenario (YAML) or a MODEL.");
  return contact_scenario(path, options);
}

}  // namespace veridyn
