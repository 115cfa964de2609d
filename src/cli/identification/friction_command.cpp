#include <iostream>
#include <memory>

#include "cli/commands.hpp"
#include "veridyn/tool/common_options.hpp"
#include "veridyn/tool/messages.hpp"
#include "tool/recording_options.hpp"
#include "files/output_file.hpp"
#include "veridyn/diagnosis/friction_study.hpp"
#include "veridyn/report/diagnosis_json.hpp"
#include "veridyn/report/pages.hpp"

namespace veridyn::cli {
namespace {

struct FrictionRequest {
  std::string robot;
  std::vector<std::string> recordings, test;
  DiagnosisOptions options;
  CommonOptions common;
};

ExitStatus run(FrictionRequest& request, const std::string& command_line) {
  require_writable(request.common.json, request.common.report);
  const Model arm = read_robot(request.robot, request.common, &request.options.identification.preprocessing.signals);
  warn_of_repeated_recordings(request.recordings);
  request.options.identification.threads = request.common.threads;
  request.options.identification.progress = progress(request.common);
  const FrictionStudy study = study_friction(arm, request.recordings, request.test, request.options);
  if (!study.reason.empty()) {
    print_message(study.reason);
    return kDataCannotAnswer;
  }
  for (const std::string& warning : study.diagnosis.baseline.warnings) print_message("warning: " + warning);
  write_results(request.common, study, command_line, &arm);
  std::cout << study.report();
  return kDone;
}

}  // namespace

void add_friction_command(CLI::App& tool, Outcome& outcome) {
  const auto request = std::make_shared<FrictionRequest>();
  CLI::App& command = *tool.add_subcommand(
      "friction", "Friction of each joint: against speed, at breakaway, and its kind");
  add_robot_argument(command, request->robot);
  add_value(command, "REC REC...", request->recordings,
            "Recordings: constant speeds, slow ramps, or any motion")
      ->required();
  add_value(command, "--test REC...", request->test,
            "Held-out recordings, which decide the kind of friction (default: the last one, or the "
            "last third of a single one)");
  add_preprocessing_options(command, request->options.identification.preprocessing);
  add_robot_options(command, request->common);
  add_common_options(command, request->common);
  add_report_option(command, request->common);
  command.callback([request, &outcome] { outcome.status = run(*request, outcome.command_line); });
}

}  // namespace veridyn::cli
