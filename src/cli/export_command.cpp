#include <memory>

#include "commands.hpp"
#include "common_options.hpp"
#include "veridyn/model/model_file.hpp"
#include "veridyn/model/urdf.hpp"

namespace veridyn::cli {
namespace {

struct Request {
  std::string model;
  std::string urdf;
  std::string yaml;
};

void run(const Request& request) {
  if (request.urdf.empty() && request.yaml.empty()) {
    throw CLI::RequiredError("--urdf or --yaml");
  }
  if (request.urdf == request.yaml) {
    throw CLI::ValidationError("--yaml", "found the same file as for --urdf");
  }
  require_writable(request.urdf);
  require_writable(request.yaml);
  const Model model = read_model(request.model);
  if (!request.urdf.empty()) save_urdf(model, request.urdf);
  if (!request.yaml.empty()) save_model(model, request.yaml);
}

}  // namespace

void add_export_command(CLI::App& tool, Outcome&) {
  const auto request = std::make_shared<Request>();
  CLI::App& command = *tool.add_subcommand("export", "A model in another format");
  command.add_option("MODEL", request->model, "Identified model, or any robot")
      ->required()
      ->option_text(" ");
  command.add_option("--urdf", request->urdf, "Write URDF")->option_text("FILE");
  command.add_option("--yaml", request->yaml, "Write YAML")->option_text("FILE");
  command.set_version_flag("--version", "veridyn " VERIDYN_VERSION);
  command.callback([request] { run(*request); });
}

}  // namespace veridyn::cli
