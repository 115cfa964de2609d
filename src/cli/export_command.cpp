#include <memory>

#include "commands.hpp"
#include "common_options.hpp"
#include "export_dvrk.hpp"
#include "veridyn/model/model_file.hpp"
#include "veridyn/model/urdf.hpp"

namespace veridyn::cli {
namespace {

struct Request {
  std::string model;
  std::string urdf;
  std::string yaml;
  DvrkExport dvrk;
};

void run(const Request& request) {
  const DvrkExport& dvrk = request.dvrk;
  if ((request.urdf + request.yaml + dvrk.gravity + dvrk.scales).empty())
    throw CLI::RequiredError("--urdf, --yaml, --dvrk-gravity or --dvrk-scales");
  check_dvrk_export(dvrk);
  for (const std::string& file : {request.urdf, request.yaml, dvrk.gravity, dvrk.scales})
    require_writable(file);
  const Model model = read_model(request.model);
  if (!request.urdf.empty()) save_urdf(model, request.urdf);
  if (!request.yaml.empty()) save_model(model, request.yaml);
  export_dvrk(model, dvrk);
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
  add_dvrk_export_options(command, request->dvrk);
  command.set_version_flag("--version", "veridyn " VERIDYN_VERSION);
  command.callback([request] { run(*request); });
}

}  // namespace veridyn::cli
