#include "veridyn/model/model_file.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iterator>

#include "math/input_file.hpp"
#include "math/beside_program.hpp"
#include "math/output_file.hpp"
#include "veridyn/math/require.hpp"
#include "model/suggestion.hpp"
#include "veridyn/model/urdf.hpp"

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
  folders.emplace_back(beside_program("share/veridyn/robots"));
  return folders;
}

bool is_urdf(const fs::path& path) {
  return path.extension() == ".urdf" || path.extension() == ".xml";
}

bool is_robot_file(const fs::path& path) {
  return path.extension() == ".yaml" || path.extension() == ".yml" || path.extension() == ".json" ||
         is_urdf(path);
}

// Finds the file of a bare name.
fs::path find_robot(const std::string& name) {
  std::error_code ignored;
  for (const fs::path& folder : robot_folders()) {
    for (const char* extension : {".yaml", ".yml", ".urdf", ".xml"}) {
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
                          there ? "" : did_you_mean(name, known), ", expected a file that ends in .yaml, .yml, .urdf or .xml, or one of: ",
                          listed(known), "."));
}

std::string content_of(const std::string& path) {
  std::error_code ignored;
  require(fs::exists(path, ignored), path, ": found no such file",
          did_you_mean(fs::path(path).stem().string(), robot_names()), ", expected a robot file.");
  return content_of_file(path, "a robot file");
}

}  // namespace

std::string robot_path(const std::string& robot) {
  const bool names_a_file = is_robot_file(robot) || robot.find('/') != std::string::npos;
  return names_a_file ? robot : find_robot(robot).string();
}

Model read_model(const std::string& robot, const ModelFileOptions& options) {
  const std::string path = robot_path(robot);
  if (!is_urdf(path)) return read_yaml(content_of(path), path, options);
  require(options.constants.empty(), path,
          ": found a URDF file, which has no constants, expected YAML.");
  return read_urdf(path);
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
