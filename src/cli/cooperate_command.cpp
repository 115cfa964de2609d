#include <iostream>
#include <memory>

#include "commands.hpp"
#include "common_options.hpp"
#include "messages.hpp"
#include "veridyn/cooperation/scenario_run.hpp"
#include "veridyn/math/output_file.hpp"
#include "veridyn/model/suggestion.hpp"
#include "veridyn/simulation/engine.hpp"

namespace veridyn::cli {
namespace {

struct Request {
  std::string scenario, output;
  std::string engine = "veridyn";
  CommonOptions common;
};

ExitStatus run(const Request& request) {
  require_different({{"--output", request.output},
                     {"--json", request.common.json},
                     {"--report", request.common.report}});
  for (const std::string& path : {request.output, request.common.json, request.common.report})
    require_writable(path);
  const Scenario scenario = read_scenario(request.scenario);
  const Progress bar = progress(request.common);
  const auto told = [&](double share) {
    if (bar) bar("cooperating", share);
  };
  const ScenarioRun done = run_scenario(scenario, request.engine, told);
  if (!request.output.empty()) write_scenario_rows(done, request.output);
  std::cout << done.report();
  return done.complete() ? kDone : kDataCannotAnswer;
}

}  // namespace

void add_cooperate_command(CLI::App& tool, Outcome& outcome) {
  const auto request = std::make_shared<Request>();
  CLI::App& command =
      *tool.add_subcommand("cooperate", "Arms that hold one object together, in simulation");
  command.add_option("SCENARIO", request->scenario, "YAML: arms, object, loops, phases")
      ->required()
      ->option_text(" ");
  command.add_option("-o,--output", request->output, "Write what happened as CSV")
      ->option_text("FILE");
  command.add_option("--engine", request->engine, "What computes the motion (veridyn)")
      ->option_text(listed(engine_names()))
      ->check(CLI::IsMember(engine_names()));
  add_common_options(command, request->common);
  add_report_option(command, request->common);
  command.callback([request, &outcome] { outcome.status = run(*request); });
}

}  // namespace veridyn::cli
