#include <iostream>
#include <memory>

#include "cli/commands.hpp"
#include "cli/options/common_options.hpp"
#include "math/output_file.hpp"
#include "veridyn/model/model_file.hpp"
#include "veridyn/report/json.hpp"
#include "veridyn/report/pages.hpp"

namespace veridyn::cli {
namespace {

struct InfoRequest {
  std::string robot;
  CommonOptions common;
};

void run(const InfoRequest& request, const std::string& command_line) {
  require_writable(request.common.json);
  require_writable(request.common.report);
  const RobotInfo info = robot_info(read_model(request.robot));
  if (!request.common.json.empty()) write_file(request.common.json, to_json(info));
  if (!request.common.report.empty()) write_file(request.common.report, to_page(info, command_line));
  std::cout << info.report();
}

}  // namespace

void add_info_command(CLI::App& tool, Outcome& outcome) {
  const auto request = std::make_shared<InfoRequest>();
  CLI::App& command =
      *tool.add_subcommand("info", "What a robot file says, and which parameters torques can tell");
  add_robot_argument(command, request->robot);
  add_common_options(command, request->common);
  add_report_option(command, request->common);
  command.callback([request, &outcome] { run(*request, outcome.command_line); });
}

}  // namespace veridyn::cli
