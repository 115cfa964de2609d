#include <iostream>
#include <memory>

#include "cli/commands.hpp"
#include "veridyn/tool/common_options.hpp"
#include "veridyn/tool/messages.hpp"
#include "veridyn/tool/sound_arguments.hpp"
#include "files/output_file.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/report/json.hpp"
#include "veridyn/report/pages.hpp"

namespace veridyn::cli {
namespace {

struct InfoRequest {
  std::string robot;
  std::string yaml;
  CommonOptions common;
};

void run(const InfoRequest& request, const std::string& command_line) {
  require_writable(request.common.json, request.common.report, request.yaml);
  const Model arm = read_model(request.robot);
  const RobotInfo info = while_busy(request.common, "finding what torques can identify", [&] { return robot_info(arm); });
  if (!request.yaml.empty()) save_model(arm, request.yaml);
  write_results(request.common, info, command_line);
  std::cout << info.report();
}

}  // namespace

void add_info_command(CLI::App& tool, Outcome& outcome) {
  const auto request = std::make_shared<InfoRequest>();
  CLI::App& command = *tool.add_subcommand(
      "info", "Structure of a robot file, and the parameters that torques can identify");
  add_robot_argument(command, request->robot);
  add_output_option(command, "--yaml", request->yaml,
                    "Write the robot as YAML, to go on with: drive gains, effects, boxes, constants");
  add_common_options(command, request->common);
  add_report_option(command, request->common);
  command.callback([request, &outcome] { run(*request, outcome.command_line); });
}

}  // namespace veridyn::cli
