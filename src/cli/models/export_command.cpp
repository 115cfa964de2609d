#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "veridyn/tool/common_options.hpp"
#include "cli/models/simulation_output.hpp"
#include "veridyn/tool/messages.hpp"
#include "veridyn/tool/open_commands.hpp"
#include "veridyn/tool/option_checks.hpp"
#include "veridyn/tool/sound_arguments.hpp"
#include "tool/recording_options.hpp"
#include "files/robot_format.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/c_code.hpp"
#include "veridyn/files/mjcf.hpp"
#include "veridyn/files/model_json.hpp"
#include "veridyn/identification/portable_model.hpp"
#include "veridyn/files/sdf.hpp"
#include "veridyn/model/joint_sensors.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/files/model_origin.hpp"
#include "veridyn/files/urdf.hpp"
#include "veridyn/report/pages.hpp"
#include "veridyn/report/robot_info.hpp"

namespace veridyn::cli {
namespace {

struct ExportRequest {
  std::string model;
  std::string urdf, mjcf, sdf, cpp, yaml, json, report;
  std::string prior, meshes_from, into;
  bool quiet = false;
  std::optional<ExportExtension> extension;
};

ExportedModel exported(const ExportRequest& request, const Model& model, RotorPlace rotors) {
  std::optional<Model> prior;
  if (!request.prior.empty()) prior = read_model(request.prior);
  return exported_model(model, prior, request.meshes_from, rotors);
}

// Prints notes, after the files are written, so that an error prints nothing else.
void print_notes(const ExportRequest& request, const ExportedModel& out) {
  for (const std::string& warning : out.warnings)
    print_message("warning: " + request.model + ": " + warning + ".");
  if (request.quiet) return;
  for (const std::string& note : out.notes) print_message(note + ".");
}

// The model as YAML, with its origin.
std::string yaml_of(const ExportRequest& request, const Model& model) {
  const std::string path = robot_path(request.model);
  const bool yaml = robot_format(path) == RobotFormat::kYaml;
  const std::optional<ModelOrigin> origin = yaml ? read_origin(path) : std::nullopt;
  return origin ? with_origin(to_yaml(model), *origin) : to_yaml(model);
}

// The simulator's file into which the model's values are written: the file that the user named, or that of the
// model's origin; empty if it has another format.
std::string simulation_of(const ExportRequest& request, const Model& model, RobotFormat format) {
  const std::string& source = model.description().source;
  const std::string& file = request.into.empty() ? source : request.into;
  std::error_code ignored;
  const bool exists = std::filesystem::is_regular_file(file, ignored);
  return exists && robot_format(file) == format ? file : "";
}

// Adds the URDF, MJCF and SDF files.
void add_xml(const ExportRequest& request, const Model& model, const ExportedModel& out, std::vector<FileToWrite>& files) {
  if (!request.urdf.empty()) files.push_back(simulation_xml(request.urdf, "URDF", to_urdf(out.arm, out.extras)));
  if (!request.mjcf.empty()) {
    const std::string from = simulation_of(request, out.arm, RobotFormat::kMjcf);
    if (from.empty()) {
      const ExportedModel own = exported(request, model, RotorPlace::kArmatures);
      files.push_back(simulation_xml(request.mjcf, "MJCF", to_mjcf(own.arm, own.extras.remarks)));
    } else {
      files.push_back(updated_simulation(out.arm, from, request.mjcf));
    }
  }
  if (!request.sdf.empty()) {
    const std::string from = simulation_of(request, out.arm, RobotFormat::kSdf);
    files.push_back(from.empty() ? simulation_xml(request.sdf, "SDF", to_sdf(out.arm, out.extras))
                                 : updated_simulation(out.arm, from, request.sdf));
  }
}

void run(const ExportRequest& request, const std::string& command_line) {
  std::vector<std::string> paths = {request.urdf, request.mjcf, request.sdf,   request.cpp,
                                    request.yaml, request.json, request.report};
  if (request.extension) {
    for (const std::string& path : request.extension->paths()) paths.push_back(path);
  }
  if (std::all_of(paths.begin(), paths.end(), [](const std::string& path) { return path.empty(); })) {
    throw CLI::RequiredError("--urdf, --mjcf, --sdf, --cpp, --json" +
                             (request.extension ? ", --yaml, " + request.extension->options : " or --yaml"));
  }
  if (request.extension) request.extension->check();
  for (const std::string& path : paths) require_writable(path);
  const Model model = read_model(request.model);
  if (!request.into.empty()) {
    const std::optional<RobotFormat> format = robot_format(request.into);
    expect_value(format == RobotFormat::kMjcf ? !request.mjcf.empty() : format == RobotFormat::kSdf && !request.sdf.empty(), "--into",
                 "found '", request.into, "', expected an MJCF file with --mjcf, or an SDF file with --sdf");
    require(std::filesystem::is_regular_file(request.into), request.into, ": found no such file, expected that of a simulation.");
  }
  std::vector<FileToWrite> files;
  if (!(request.urdf + request.mjcf + request.sdf + request.report).empty()) {
    const ExportedModel out = exported(request, model, RotorPlace::kBodies);
    add_xml(request, model, out, files);
    if (request.quiet) {
      for (FileToWrite& file : files) file.tell = {};
    }
    if (!request.report.empty()) files.push_back({request.report, to_page(robot_info(out.arm), command_line)});
    files.back().tell = [before = files.back().tell, &request, out] {
      if (before) before();
      print_notes(request, out);
    };
  }
  if (!request.cpp.empty()) files.push_back({request.cpp, to_c_code(model)});
  if (!request.yaml.empty()) files.push_back({request.yaml, yaml_of(request, model)});
  if (!request.json.empty()) files.push_back({request.json, model_json(model)});
  if (request.extension) request.extension->add_files(model, files);
  write_all(files);
  warn_of_impossible_bodies(request.model, model);
  if (request.quiet) return;
  for (const std::string& error : JointSensors(model).descriptions(model))
    print_message("the exported dynamics mean true positions and torques, and " + error +
        ": take it off first (docs/control.md).");
}

}  // namespace

void add_export_command(CLI::App& tool, Outcome& outcome, const std::optional<ExportExtension>& extension) {
  const auto request = std::make_shared<ExportRequest>();
  request->extension = extension;
  CLI::App& command = *tool.add_subcommand(
      "export", "Convert a model: URDF, MJCF, SDF, C, YAML, JSON, dVRK gravity");
  add_value(command, "MODEL", request->model, "Identified model, or any robot")->required();
  const auto file = [&command](const char* option, std::string& target, const char* help) {
    add_output_option(command, option, target, help);
  };
  file("--urdf", request->urdf, "Write URDF; meshes of the original URDF are kept");
  file("--mjcf", request->mjcf, "Write MJCF for MuJoCo");
  file("--sdf", request->sdf, "Write SDFormat, for Gazebo");
  file("--cpp,--c", request->cpp,
       "Write one file of C and C++: inverse dynamics, regressor, friction; no dependencies");
  file("--json", request->json, "Write the robot file as JSON");
  file("--yaml", request->yaml, "Write YAML");
  file("--report", request->report, "Write one HTML page of the arm with the bodies that are exported");
  add_value(command, "--prior MODEL", request->prior,
            "With --urdf, --mjcf and --sdf: prior model (CAD) for values that torques do not "
            "determine (default: small rods)");
  add_value(command, "--meshes-from URDF", request->meshes_from,
            "With --urdf and --sdf: URDF file to take meshes from (default: the one that the model "
            "came from)");
  add_value(command, "--into FILE", request->into,
            "With --mjcf and --sdf: simulation's file whose values are replaced; all else of it "
            "stays (default: the file that the model came from)");
  command.add_flag("--quiet", request->quiet, "Print only errors on standard error");
  if (extension) extension->add_options(command);
  command.set_version_flag("--version", "veridyn " VERIDYN_VERSION);
  command.callback([request, &outcome, &command] {
    const bool urdf_or_sdf = !(request->urdf + request->sdf).empty();
    const bool bodies = urdf_or_sdf || !(request->mjcf + request->report).empty();
    expect_prerequisites(command, {{"--prior", bodies, "--urdf, --mjcf, --sdf or --report"},
                                   {"--meshes-from", urdf_or_sdf, "--urdf or --sdf"}});
    run(*request, outcome.command_line);
  });
}

}  // namespace veridyn::cli
