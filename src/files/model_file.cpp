#include "veridyn/files/model_file.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iterator>

#include "files/input_file.hpp"
#include "files/path_near_program.hpp"
#include "files/output_file.hpp"
#include "veridyn/math/require.hpp"
#include "files/robot_format.hpp"
#include "model/suggestion.hpp"
#include "files/xml_file.hpp"
#include "veridyn/files/simulator_files.hpp"
#include "veridyn/files/urdf.hpp"

namespace veridyn {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> robot_folders() {
  std::vector<fs::path> folders;
  if (const char* own = std::getenv("VERIDYN_ROBOTS")) folders.emplace_back(own);
#ifdef VERIDYN_ROBOTS_SOURCE_DIR
  folders.emplace_back(VERIDYN_ROBOTS_SOURCE_DIR);
#endif
#ifdef VERIDYN_ROBOTS_INSTALL_DIR
  folders.emplace_back(VERIDYN_ROBOTS_INSTALL_DIR);
#endif
  folders.emplace_back(path_near_program("share/veridyn/robots"));
  return folders;
}

const char* const kEndings[] = {".yaml", ".yml", ".urdf", ".xml", ".mjcf", ".sdf"};

bool is_robot_file(const fs::path& path) {
  return path.extension() == ".json" || std::find(std::begin(kEndings), std::end(kEndings), path.extension()) != std::end(kEndings);
}

// Finds the file of a robot that is given by its bare name.
fs::path find_robot(const std::string& name) {
  std::error_code ignored;
  for (const fs::path& folder : robot_folders()) {
    for (const char* extension : kEndings) {
      const fs::path file = folder / (name + extension);
      if (fs::is_regular_file(file, ignored)) return file;
    }
  }
  const std::vector<std::string> known = robot_names();
  const bool there = fs::exists(name, ignored);
  throw InvalidInput(text(name,
                          fs::is_directory(name, ignored) ? ": found a folder"
                          : there                         ? ": found a file that is no robot's"
                                                          : ": found no robot of this name",
                          there ? "" : did_you_mean(name, known), ", expected a file that ends in .yaml, .yml, .urdf, .xml, .mjcf or .sdf, or one of: ",
                          listed(known), "."));
}

void require_file(const std::string& path) {
  std::error_code ignored;
  require(fs::exists(path, ignored), path, ": found no such file",
          did_you_mean(fs::path(path).stem().string(), robot_names()), ", expected a robot file.");
}

}  // namespace

std::string robot_path(const std::string& robot) {
  const bool names_a_file = is_robot_file(robot) || robot.find('/') != std::string::npos;
  return names_a_file ? robot : find_robot(robot).string();
}

Model read_model(const std::string& robot, const ModelFileOptions& options) {
  const std::string path = robot_path(robot);
  require_file(path);
  const RobotFormat format = robot_format(path).value_or(RobotFormat::kYaml);
  if (format == RobotFormat::kYaml) return read_yaml(content_of_file(path, "a robot file"), path, options);
  require(options.constants.empty(), path, ": found a ",
          format == RobotFormat::kUrdf ? "URDF" : format == RobotFormat::kMjcf ? "MJCF" : "SDF",
          " file, which has no constants, expected YAML.");
  return format == RobotFormat::kUrdf ? read_urdf(path) : format == RobotFormat::kMjcf ? read_mjcf(path) : read_sdf(path);
}

std::optional<RobotFormat> robot_format(const std::string& path) {
  const std::string ending = fs::path(path).extension().string();
  if (ending == ".yaml" || ending == ".yml" || ending == ".json") return RobotFormat::kYaml;
  if (ending == ".urdf") return RobotFormat::kUrdf;
  if (ending == ".mjcf") return RobotFormat::kMjcf;
  if (ending == ".sdf") return RobotFormat::kSdf;
  if (ending != ".xml") return std::nullopt;
  std::error_code ignored;
  const std::string root = fs::is_regular_file(path, ignored) ? root_element(path) : std::string();
  return root == "mujoco" ? RobotFormat::kMjcf : root == "sdf" ? RobotFormat::kSdf : RobotFormat::kUrdf;
}

void save_model(const Model& arm, const std::string& path) {
  write_file(path, to_yaml(arm));
}

std::vector<std::string> robot_names() {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const fs::path& folder : robot_folders()) {
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
      if (is_robot_file(entry.path())) names.push_back(entry.path().stem().string());
    }
  }
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

}  // namespace veridyn
