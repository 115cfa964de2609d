#include "cooperate_boards.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>

#include "dvrk_request.hpp"
#include "math/output_file.hpp"
#include "messages.hpp"
#include "option_checks.hpp"
#include "dvrk/arms/arm_facts.hpp"
#include "dvrk/cooperation/board_cooperation.hpp"
#include "report/cooperation_json.hpp"

namespace veridyn::cli {
namespace {

dvrk::CooperatingArm board_arm(const std::string& config) {
  dvrk::CooperatingArm out;
  std::error_code ignored;
  const std::vector<std::string> known = dvrk::arm_names();
  const bool is_file = std::filesystem::is_regular_file(config, ignored);
  if (!is_file) expect_one_of("--boards", config, known);
  const dvrk::IoConfig whole =
      is_file ? dvrk::read_io_config(config) : dvrk::nominal_config(dvrk::read_arm(config));
  out.robot = whole.robot("");
  const std::string& name = is_file ? out.robot.name : config;
  if (std::find(known.begin(), known.end(), name) != known.end())
    out.coupling = dvrk::read_arm(name).coupling();
  return out;
}

void place(const std::string& host, dvrk::CooperatingArm& arm) {
  const auto colon = host.rfind(':');
  arm.host = host.substr(0, colon);
  if (colon == std::string::npos) return;
  char* end = nullptr;
  const long port = std::strtol(host.c_str() + colon + 1, &end, 10);
  expect_value(*end == '\0' && port > 0 && port < 65536, "--board-hosts", "found '", host,
               "', expected HOST or HOST:PORT.");
  arm.port = static_cast<std::uint16_t>(port);
}

// "silent:slave@4.5".
void set_fault(const std::string& words, const Scenario& scenario,
               dvrk::BoardCooperationOptions& options) {
  if (words.empty()) return;
  const auto colon = words.find(':');
  const auto at = words.rfind('@');
  const bool formed = colon != std::string::npos && at != std::string::npos && colon < at;
  const std::string what = words.substr(0, colon);
  char* end = nullptr;
  options.fault_at = formed ? std::strtod(words.c_str() + at + 1, &end) : 0.0;
  expect_value(formed && *end == '\0' && (what == "silent" || what == "amplifier"), "--board-fault",
               "found '", words, "', expected silent:ARM@SECONDS or amplifier:ARM@SECONDS.");
  const std::string name = words.substr(colon + 1, at - colon - 1);
  const auto arm = std::find_if(scenario.arms.begin(), scenario.arms.end(),
                                [&](const ScenarioArm& a) { return a.name == name; });
  expect_value(arm != scenario.arms.end(), "--board-fault", "found no arm '", name,
               "' in the scenario.");
  const auto index = static_cast<int>(arm - scenario.arms.begin());
  (what == "silent" ? options.silent_arm : options.broken_arm) = index;
}

}  // namespace

void add_boards_options(CLI::App& command, BoardsRequest& request) {
  command
      .add_option("--boards", request.configs,
                  "Run on dVRK boards: a configuration (XML, JSON, or PSM1, ...) for each arm")
      ->option_text("IO...");
  command.add_option("--board-hosts", request.hosts, "Where they are, one for each arm")
      ->option_text("HOST[:PORT]...");
  command.add_flag("--emulate", request.emulate,
                   "Emulate the boards, arms joined through the scenario's world, over UDP sockets");
  command.add_option("--force-sensor", request.sensors, "For each member: serial:... or udp:PORT")
      ->option_text("SOURCE...");
  command.add_option("--force-calibration", request.calibrations, "For each sensor")
      ->option_text("FILE...");
  command.add_option("--board-fault", request.fault, "Of emulated boards: a fault to come")
      ->option_text("silent:ARM@S|amplifier:ARM@S");
}

ExitStatus run_boards(const BoardsRequest& request, const Scenario& scenario,
                      const CommonOptions& common, const std::string& output,
                      const std::string& command_line) {
  expect_value(request.configs.size() == scenario.arms.size(), "--boards", "found ",
               request.configs.size(), " configurations, expected one for each of ",
               scenario.arms.size(), " arms.");
  expect_value(request.emulate || request.hosts.size() == scenario.arms.size(), "--board-hosts",
               "found ", request.hosts.size(), ", expected one for each of ", scenario.arms.size(),
               " arms, or --emulate.");
  std::vector<dvrk::CooperatingArm> arms;
  for (const std::string& config : request.configs) arms.push_back(board_arm(config));
  for (std::size_t k = 0; k < request.hosts.size() && k < arms.size(); ++k)
    place(request.hosts[k], arms[k]);
  dvrk::BoardCooperationOptions options;
  options.emulate = request.emulate;
  options.force_sources = request.sensors;
  options.force_calibrations = request.calibrations;
  set_fault(request.fault, scenario, options);
  catch_signals();
  const dvrk::BoardCooperationRun done =
      dvrk::run_on_boards(scenario, arms, options, stop_asked());
  if (!output.empty()) write_scenario_rows(done.run, output);
  if (!common.json.empty()) write_file(common.json, to_json(done.run, scenario));
  if (!common.report.empty())
    write_file(common.report, to_page(done.run, scenario, command_line));
  std::cout << done.report();
  return done.end == dvrk::BoardEnd::kDone && done.run.met() ? kDone : kDataCannotAnswer;
}

}  // namespace veridyn::cli
