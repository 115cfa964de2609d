#include <iostream>
#include <memory>

#include "cli/commands.hpp"
#include "veridyn/tool/common_options.hpp"
#include "veridyn/tool/messages.hpp"
#include "veridyn/tool/option_checks.hpp"
#include "tool/recording_options.hpp"
#include "cli/options/rest_options.hpp"
#include "veridyn/diagnosis/payload.hpp"
#include "files/output_file.hpp"
#include "veridyn/report/pages.hpp"
#include "veridyn/report/payload_json.hpp"

namespace veridyn::cli {
namespace {

struct PayloadRequest {
  std::string model;
  std::vector<std::string> recordings;
  std::string link;
  RestRequest rest;
  IdentificationOptions options;
  CommonOptions common;
};

ExitStatus run(PayloadRequest& request, const std::string& command_line) {
  require_writable(request.common.json, request.common.report);
  const Model model = read_robot(request.model, request.common, &request.options.preprocessing.signals);
  warn_of_impossible_bodies(request.model, model);
  const bool at_rest = are_rest_poses(request.rest, model, request.recordings, request.options.preprocessing);
  if (!at_rest && model.inertial_values() && !has_all_values(model))
    print_message("'" + model.name() + "' has effects without values: they are fitted to the recordings first, with its bodies as they are");
  if (!request.link.empty()) expect_one_of("--link", request.link, frame_names(model));
  request.options.threads = request.common.threads;
  if (!at_rest) check_recordings(model, request.recordings, request.options.preprocessing, request.options.threads);
  const PayloadReport report = while_busy(request.common, "fitting a load on every link", [&] {
    if (at_rest) return find_payload(model, read_poses(request.rest, model, request.recordings, {}, request.options).first, request.options, request.link);
    return find_payload(model, request.recordings, request.options, request.link);
  });
  if (report.links.empty()) {
    print_message(report.reason);
    return kDataCannotAnswer;
  }
  write_results(request.common, report, command_line);
  std::cout << report.report();
  return kDone;
}

}  // namespace

void add_payload_command(CLI::App& tool, Outcome& outcome) {
  const auto request = std::make_shared<PayloadRequest>();
  CLI::App& command = *tool.add_subcommand(
      "payload", "Mass, centre of mass and inertia of a load that the model lacks");
  command.add_option("MODEL", request->model, "Model file written by identify or diagnose")
      ->required();
  add_value(command, "REC,--recording REC...", request->recordings, "Recordings with the load")
      ->required();
  add_value(command, "--link FRAME", request->link,
            "Test only the link of this frame (default: all)");
  add_rest_options(command, request->rest, "a load shows by gravity alone");
  add_preprocessing_options(command, request->options.preprocessing);
  add_robot_options(command, request->common);
  add_common_options(command, request->common);
  add_report_option(command, request->common);
  command.callback([request, &command, &outcome] {
    request->options.choose_velocities = command.count("--velocity") == 0;
    outcome.status = run(*request, outcome.command_line);
  });
}

}  // namespace veridyn::cli
