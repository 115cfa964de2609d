#include <iostream>
#include <memory>

#include "cli/cooperation/commands.hpp"
#include "veridyn/tool/common_options.hpp"
#include "cli/cooperation/cooperate_boards.hpp"
#include "veridyn/tool/kept_results.hpp"
#include "veridyn/tool/messages.hpp"
#include "veridyn/tool/option_checks.hpp"
#include "cooperation/scenario/scenario_models.hpp"
#include "veridyn/tool/sound_arguments.hpp"
#include "veridyn/cooperation/live.hpp"
#include "veridyn/cooperation/scenario_run.hpp"
#include "veridyn/cooperation/scenario_sweep.hpp"
#include "veridyn/cooperation/teleoperation_scenario.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/file_hash.hpp"
#include "veridyn/files/output_file.hpp"
#include "veridyn/model/suggestion.hpp"
#include "report/json/cooperation_json.hpp"
#include "veridyn/simulation/engine.hpp"

namespace veridyn::cli {
namespace {

struct CooperateRequest {
  const CLI::App* command = nullptr;  // the command whose options were given
  std::string scenario, output;
  std::string resume;  // file of a sweep's finished points
  std::string engine = "veridyn";
  bool sweep = false;
  LiveRequest live;
  BoardsRequest boards;
  CommonOptions common;
};

void report_assumed_values(const CooperateRequest& request, const Scenario& scenario) {
  if (request.common.quiet) return;
  for (const std::string& line : assumed_values(scenario)) print_message(line);
}

// Prints the report and writes the requested JSON and page.
template <typename Result>
void write_results(const CooperateRequest& request, const Result& done, const Scenario& scenario,
           const std::string& command) {
  report_assumed_values(request, scenario);  // after the run, so that an error prints only one line
  if (!request.common.json.empty()) write_file(request.common.json, to_json(done, scenario));
  if (!request.common.report.empty())
    write_file(request.common.report, to_page(done, scenario, command));
  std::cout << done.report();
}

// A sweep whose finished points survive a kill. Points that ended early are not stored: they take little
// time.
ScenarioSweepResult run_sweep(const CooperateRequest& request, const Scenario& scenario,
                              const std::function<void(double)>& progress) {
  SweepOptions options;
  options.engine = request.engine;
  options.threads = request.common.threads;
  options.progress = progress;
  if (request.resume.empty()) return sweep_scenario(scenario, options);
  std::string depends_on = text(VERIDYN_VERSION, "\n", request.engine, "\n", sha256_of_file(request.scenario));
  for (const ScenarioArm& arm : scenario.arms)
    depends_on += text("\n", arm.model, " ", sha256_of_file(arm.model), "\n", arm.controller_model, " ", sha256_of_file(arm.controller_model));
  KeptResults points(request.resume, "cooperate: points of the sweep", depends_on);
  options.kept = [&](int k) -> std::optional<SweepPoint> {
    const std::optional<VectorXd> numbers = points.find(k);
    if (!numbers || numbers->size() != 9) return std::nullopt;
    const VectorXd& x = *numbers;
    return SweepPoint{x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7], x[8] != 0.0, ""};
  };
  options.keep = [&](int k, const SweepPoint& p) {
    if (!p.ended.empty()) return;
    VectorXd numbers(9);
    numbers << p.stiffness, p.delay, p.rate, p.steady_error, p.force_error, p.oscillation, p.largest_force,
        p.generated, p.stable ? 1.0 : 0.0;
    points.keep(k, numbers);
  };
  return sweep_scenario(scenario, options);
}

// Runs commands from a line in real time; reports go to standard output as they occur.
ExitStatus run_live_lines(const CooperateRequest& request) {
  const Scenario scenario = read_scenario(request.scenario);
  report_assumed_values(request, scenario);
  const std::unique_ptr<LineSource> lines = open_line(request.live);
  LiveOptions options = live_options(request.live);
  options.engine = request.engine;
  const LiveRun done = run_live(scenario, *lines, options, printing_live_report());
  std::cout << done.report();
  const bool sound = done.status == StepStatus::kOk && done.state == CooperativeState::kTracking;
  return sound && !done.lost ? kDone : kDataCannotAnswer;
}

ExitStatus run(const CooperateRequest& request, const std::string& command) {
  const bool live = !request.live.line.empty();
  const bool on_boards = !request.boards.configs.empty();
  expect_prerequisites(*request.command,
                       {{"--output", !request.sweep && !live, "a run: --sweep or --live beside it has no rows"},
                        {"--resume", request.sweep, "--sweep"},
                        {"--sweep", !live && !on_boards, "no --live or --boards beside it"},
                        {"--emulate", on_boards, "--boards"},
                        {"--stepped", request.boards.emulate, "--emulate"},
                        {"--board-hosts", on_boards, "--boards"},
                        {"--board-fault", on_boards && request.boards.emulate, "--boards and --emulate"},
                        {"--force-sensor", on_boards, "--boards"},
                        {"--force-calibration", !request.boards.sensors.empty(), "--force-sensor"},
                        {"--json", !live, "no --live beside it"},
                        {"--report", !live, "no --live beside it"},
                        {"--pace", live && (!on_boards || request.boards.stepped), "--live, and --stepped on boards"},
                        {"--silence", live, "--live"}});
  if (live && !on_boards) return run_live_lines(request);
  require_writable(request.output, request.common.json, request.common.report);
  const Scenario scenario = read_scenario(request.scenario);
  if (on_boards)
    return run_boards(request.boards, request.live, scenario, request.scenario, request.common, request.output,
                      command);
  require(!is_teleoperation(request.scenario), request.scenario,
          ": found a teleoperation, which runs on boards alone: expected --boards, with --emulate "
          "for emulated ones.");
  const Progress bar = progress(request.common);
  const auto progress = [&](double share) {
    if (bar) bar("cooperating", share);
  };
  if (request.sweep) {
    write_results(request, run_sweep(request, scenario, progress), scenario, command);
    return kDone;
  }
  const ScenarioRun done = run_scenario(scenario, request.engine, progress);
  if (!request.output.empty()) write_scenario_rows(done, request.output);
  write_results(request, done, scenario, command);
  return done.met() ? kDone : kDataCannotAnswer;
}

}  // namespace

void add_cooperate_command(CLI::App& tool, Outcome& outcome) {
  const auto request = std::make_shared<CooperateRequest>();
  CLI::App& command = *tool.add_subcommand(
      "cooperate", "Control arms that hold one object, simulated or on dVRK boards");
  request->command = &command;
  add_value(command, "SCENARIO", request->scenario, "YAML: arms, object, loops, phases")
      ->required();
  add_output_option(command, "-o,--output", request->output, "Write the recorded signals as CSV", {".csv"});
  command.add_option("--engine", request->engine, "Simulation engine (veridyn)")
      ->option_text(listed(engine_names()))
      ->check(CLI::IsMember(engine_names()));
  command.add_flag("--sweep", request->sweep, "Run the scenario's sweep: a map of stability");
  add_value(command, "--resume FILE", request->resume,
            "With --sweep: keep each finished point in this file; after a kill the same command "
            "goes on from it");
  add_boards_options(command, request->boards);
  add_value(command, "--live -|udp:[ADDRESS:]PORT", request->live.line,
            "Read commands from standard input or a socket instead of the phases");
  add_value(command, "--pace X", request->live.pace,
            "With --live: simulated seconds per second (1); 0: as fast as possible",
            CLI::NonNegativeNumber);
  add_value(command, "--silence S", request->live.silence,
            "With --live udp: seconds without a command until the line counts as lost (0.5)",
            CLI::PositiveNumber);
  add_common_options(command, request->common);
  add_report_option(command, request->common);
  command.callback([request, &outcome] { outcome.status = run(*request, outcome.command_line); });
}

}  // namespace veridyn::cli
