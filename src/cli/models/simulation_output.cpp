#include "cli/models/simulation_output.hpp"

#include <CLI/CLI.hpp>
#include <filesystem>

#include "veridyn/tool/messages.hpp"
#include "files/output_file.hpp"
#include "files/robot_format.hpp"
#include "model/suggestion.hpp"
#include "veridyn/identification/portable_model.hpp"
#include "veridyn/files/simulation_file.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn::cli {

FileToWrite simulation_xml(const std::string& target, const char* format, std::string xml) {
  const std::string mark = "<!-- left out:";
  int lost = 0;
  for (std::size_t at = xml.find(mark); at != std::string::npos; at = xml.find(mark, at + 1)) ++lost;
  const std::string remark = text(target, ": ", format, " has no words for ", lost, lost == 1 ? " item" : " items",
                                  " of the model; the file names them in comments that begin with 'left out:'.");
  return {target, std::move(xml), [lost, remark] {
            if (lost > 0) print_message(remark);
          }};
}

FileToWrite updated_simulation(const Model& model, const std::string& from, const std::string& target) {
  const bool mjcf = robot_format(from) == RobotFormat::kMjcf;
  UpdatedFile updated = mjcf ? updated_mjcf(model, from) : updated_sdf(model, from);
  const std::size_t count = updated.changed.size();
  const std::string remark =
      text(target, ": ", from, " with ", count == 0 ? "no other value" : count == 1 ? "1 value" : std::to_string(count) + " values",
           " of the model", count == 0 ? "" : ": " + listed(updated.changed), "; all else stays.");
  FileToWrite out = simulation_xml(target, mjcf ? "MJCF" : "SDF", std::move(updated.xml));
  out.tell = [left_out = out.tell, remark] {
    left_out();
    print_message(remark);
  };
  return out;
}

bool is_simulation_file(const std::string& path) {
  const std::string ending = std::filesystem::path(path).extension().string();
  return ending == ".xml" || ending == ".mjcf" || ending == ".sdf";
}

void expect_simulation_of(const std::string& option, const std::string& target, const std::string& robot) {
  if (!is_simulation_file(target)) return;
  const std::optional<RobotFormat> format = robot_format(robot_path(robot));
  const bool sdf = std::filesystem::path(target).extension() == ".sdf";
  if (format == (sdf ? RobotFormat::kSdf : RobotFormat::kMjcf)) return;
  if (format == RobotFormat::kSdf && !sdf && std::filesystem::path(target).extension() == ".xml") return;
  throw CLI::ValidationError(option, "found '" + target + "', expected a .yaml file, since the robot is no " +
                                         (sdf ? "SDF" : "MJCF") + " file; `veridyn export` writes the model as " +
                                         std::filesystem::path(target).extension().string().substr(1));
}

void save_as_simulation(const Model& model, const std::string& robot, const std::string& target, bool quiet) {
  const ExportedModel out = exported_model(model, std::nullopt, "");
  for (const std::string& warning : out.warnings) print_message("warning: " + target + ": " + warning + ".");
  FileToWrite file = updated_simulation(out.arm, robot_path(robot), target);
  if (quiet) file.tell = {};
  write_all({std::move(file)});
}

}  // namespace veridyn::cli
