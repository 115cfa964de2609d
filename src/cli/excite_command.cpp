#include <iostream>
#include <memory>

#include "choice.hpp"
#include "commands.hpp"
#include "common_options.hpp"
#include "messages.hpp"
#include "veridyn/excitation/excitation.hpp"
#include "veridyn/identification/recording.hpp"
#include "veridyn/math/output_file.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/model/model_file.hpp"
#include "veridyn/report/motion_json.hpp"

namespace veridyn::cli {
namespace {

struct Request {
  std::string robot;
  std::string output;
  ExcitationOptions options;
  CommonOptions common;
};

ExitStatus run(const Request& request) {
  if (request.output == request.common.json) {
    throw CLI::ValidationError("--output", "found the same file as for --json");
  }
  require_writable(request.output);
  require_writable(request.common.json);
  ExcitationOptions options = request.options;
  options.threads = request.common.threads;
  options.progress = progress(request.common);
  const Excitation found = optimise_excitation(read_model(request.robot), options);
  if (found.status == ExcitationStatus::kRankDeficient) {
    say(text("no motion of ", found.trajectory.harmonics(),
             " harmonics was found that excites all ", found.base_parameters,
             " base parameters; more --harmonics or --starts may help."));
    return kDataCannotAnswer;
  }
  const MotionSamples motion = found.trajectory.motion(found.periods, options.rate);
  Recording rows;
  rows.time = motion.time;
  rows.q = motion.q;
  rows.dq = motion.dq;
  rows.ddq = motion.ddq;
  write_recording(rows, request.output);
  if (!request.common.json.empty()) write_file(request.common.json, to_json(found));
  std::cout << found.report();
  return kDone;
}

void add_motion_options(CLI::App& command, ExcitationOptions& o) {
  const char* const group = "Motion";
  const auto number = [&](const char* option, double& target, const char* unit, const char* help) {
    command.add_option(option, target, help)
        ->option_text(unit)
        ->check(CLI::PositiveNumber)
        ->capture_default_str()
        ->group(group);
  };
  number("--frequency", o.frequency, "HZ", "Of the slowest wave (0.13)");
  command.add_option("--harmonics", o.harmonics, "Waves per joint (5)")
      ->option_text("N")
      ->check(CLI::Range(2, 100))
      ->group(group);
  number("--duration", o.duration, "S", "Rounded to whole periods, at least two (30)");
  number("--rate", o.rate, "HZ", "Rows per second (200)");
  command
      .add_option("--limit-share", o.limit_share,
                  "Share of range, speed and acceleration to use (0.95)")
      ->option_text("X")
      ->check(CLI::Range(0.01, 1.0))
      ->group(group);
}

void add_search_options(CLI::App& command, ExcitationOptions& o) {
  const char* const group = "Search";
  add_choice(command, "--criterion", o.criterion,
             {ExcitationCriterion::kCondition, ExcitationCriterion::kDOptimal,
              ExcitationCriterion::kDiscriminate},
             "Smallest condition number or confidence ellipsoid, or two causes told apart")
      ->group(group);
  add_choice(command, "--columns-scaled", o.scaling, {ColumnScaling::kNorm, ColumnScaling::kNone},
             "Columns of the regressor before its condition number")
      ->group(group);
  add_choice(command, "--solver", o.solver,
             {ExcitationSolver::kIpopt, ExcitationSolver::kNlopt, ExcitationSolver::kDerivativeFree,
              ExcitationSolver::kRandom},
             "Who searches")
      ->group(group);
  command.add_option("--starts", o.starts, "Independent searches (2)")
      ->option_text("N")
      ->check(CLI::Range(1, 100000))
      ->group(group);
  command.add_option("--iterations,--evaluations", o.iterations, "Of each search, at most (400)")
      ->option_text("N")
      ->check(CLI::Range(1, 100000000))
      ->group(group);
  command.add_option("--seed", o.seed, "The same seed gives the same motion (1)")
      ->option_text("N")
      ->group(group);
}

}  // namespace

void add_excite_command(CLI::App& tool, Outcome& outcome) {
  const auto request = std::make_shared<Request>();
  CLI::App& command = *tool.add_subcommand(
      "excite", "A motion that starts and stops at rest and tells the parameters apart");
  add_robot_argument(command, request->robot);
  command.add_option("-o,--output", request->output, "Write the motion as CSV: t, q, dq, ddq")
      ->required()
      ->option_text("FILE");
  add_motion_options(command, request->options);
  add_search_options(command, request->options);
  add_common_options(command, request->common);
  command.callback([request, &outcome] { outcome.status = run(*request); });
}

}  // namespace veridyn::cli
