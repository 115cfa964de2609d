#include <iostream>
#include <memory>

#include "cli/commands.hpp"
#include "veridyn/tool/common_options.hpp"
#include "files/output_file.hpp"
#include "veridyn/tool/messages.hpp"
#include "veridyn/tool/sound_arguments.hpp"
#include "veridyn/identification/fleet.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/report/json.hpp"
#include "veridyn/report/pages.hpp"

namespace veridyn::cli {
namespace {

struct FleetRequest {
  std::string robot, list, model_out;
  FleetOptions options;
  CommonOptions common;
};

ExitStatus run(const FleetRequest& request, const std::string& command_line) {
  const std::vector<FleetArm> arms = read_fleet(request.list);
  for (const FleetArm& one : arms) {
    require_separate_output("--model-out", request.model_out, one.files);
    require_separate_output("--json", request.common.json, one.files);
  }
  require_writable(request.common.json, request.common.report, request.model_out);
  const Model arm = read_model(request.robot);
  FleetOptions options = request.options;
  options.threads = request.common.threads;
  options.progress = progress(request.common);
  const Fleet fleet = identify_fleet(arm, arms, options);
  for (const UnusedRecording& r : fleet.unusable_recordings) print_message("warning: left out: " + r.why);
  write_results(request.common, fleet, command_line);
  if (!fleet.model) {
    print_message(request.list + ": " + fleet.reason + ".");
    return kDataCannotAnswer;
  }
  if (!request.model_out.empty()) save_model(*fleet.model, request.model_out);
  std::cout << fleet.report();
  return kDone;
}

}  // namespace

void add_fleet_command(CLI::App& tool, Outcome& outcome) {
  const auto request = std::make_shared<FleetRequest>();
  CLI::App& command = *tool.add_subcommand(
      "fleet", "One model for many arms of a type, and the arms that differ from it");
  add_robot_argument(command, request->robot);
  add_value(command, "LIST", request->list,
            "Lines ARM,FILE: recordings, or factor files of identify --factor-out")
      ->required();
  add_value(command, "--significance P", request->options.significance,
            "Probability of naming an arm although all are alike (0.01)", CLI::Range(1e-12, 0.5));
  add_output_option(command, "--model-out", request->model_out, "Write the fleet's model as YAML");
  add_preprocessing_options(command, request->options.preprocessing);
  add_common_options(command, request->common);
  add_report_option(command, request->common);
  command.callback([request, &outcome] { outcome.status = run(*request, outcome.command_line); });
}

}  // namespace veridyn::cli
