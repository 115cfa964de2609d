#include <iostream>
#include <memory>

#include "commands.hpp"
#include "common_options.hpp"
#include "messages.hpp"
#include "option_checks.hpp"
#include "veridyn/cooperation/scenario_run.hpp"
#include "veridyn/cooperation/scenario_sweep.hpp"
#include "math/output_file.hpp"
#include "model/suggestion.hpp"
#include "veridyn/report/cooperation_json.hpp"
#include "veridyn/simulation/engine.hpp"

namespace veridyn::cli {
namespace {

struct Request {
  const CLI::App* command = nullptr;  // where the options were given
  std::string scenario, output;
  std::string engine = "veridyn";
  bool sweep = false;
  CommonOptions common;
};

template <typename Result>
void write(const Request& request, const Result& done, const Scenario& scenario,
           const std::string& command) {
  if (!request.common.json.empty()) write_file(request.common.json, to_json(done, scenario));
  if (!request.common.report.empty())
    write_file(request.common.report, to_page(done, scenario, command));
  std::cout << done.report();
}

ExitStatus run(const Request& request, const std::string& command) {
  expect_needs(*request.command,
               {{"--output", !request.sweep, "a run: --sweep beside it has no rows"}});
  for (const std::string& path : {request.output, request.common.json, request.common.report})
    require_writable(path);
  const Scenario scenario = read_scenario(request.scenario);
  const Progress bar = progress(request.common);
  const auto told = [&](double share) {
    if (bar) bar("cooperating", share);
  };
  if (request.sweep) {
    write(request, sweep_scenario(scenario, request.engine, request.common.threads, told), scenario,
          command);
    return kDone;
  }
  const ScenarioRun done = run_scenario(scenario, request.engine, told);
  if (!request.output.empty()) write_scenario_rows(done, request.output);
  write(request, done, scenario, command);
  return done.complete() ? kDone : kDataCannotAnswer;
}

}  // namespace

void add_cooperate_command(CLI::App& tool, Outcome& outcome) {
  const auto request = std::make_shared<Request>();
  CLI::App& command =
      *tool.add_subcommand("cooperate", "Arms that hold one object together, in simulation");
  request->command = &command;
  command.add_option("SCENARIO", request->scenario, "YAML: arms, object, loops, phases")
      ->required()
      ->option_text(" ");
  command.add_option("-o,--output", request->output, "Write what happened as CSV")
      ->option_text("FILE");
  command.add_option("--engine", request->engine, "What computes the motion (veridyn)")
      ->option_text(listed(engine_names()))
      ->check(CLI::IsMember(engine_names()));
  command.add_flag("--sweep", request->sweep,
                   "Run the scenario's sweep instead: a map of stability");
  add_common_options(command, request->common);
  add_report_option(command, request->common);
  command.callback([request, &outcome] { outcome.status = run(*request, outcome.command_line); });
}

}  // namespace veridyn::cli
