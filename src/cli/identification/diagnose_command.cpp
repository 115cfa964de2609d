#include <iostream>
#include <memory>

#include "veridyn/tool/choice.hpp"
#include "cli/commands.hpp"
#include "veridyn/tool/common_options.hpp"
#include "veridyn/tool/messages.hpp"
#include "veridyn/tool/option_checks.hpp"
#include "tool/recording_options.hpp"
#include "cli/options/rest_options.hpp"
#include "cli/models/simulation_output.hpp"
#include "veridyn/tool/sound_arguments.hpp"
#include "veridyn/diagnosis/diagnosis.hpp"
#include "diagnosis/preparation/diagnosis_state.hpp"
#include "files/output_file.hpp"
#include "effects/effect_names.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/report/diagnosis_json.hpp"
#include "veridyn/report/pages.hpp"
#include "veridyn/report/setting_names.hpp"

namespace veridyn::cli {
namespace {

struct DiagnoseRequest {
  std::string robot;
  std::vector<std::string> train, test;
  std::optional<RowRange> test_rows;
  std::string model_out;
  std::string values;
  bool small_apart = true;
  RestRequest rest;
  DiagnosisOptions options;
  CommonOptions common;
};

// Checks that all names are effects, or causes EFFECT:PLACE of the arm.
void expect_known_effects(const std::vector<std::string>& names) {
  for (const std::string& name : names)
    expect_one_of("--effects", split_cause(name).effect, effect_names());
}

void expect_known_places(const Model& arm, const std::vector<std::string>& names) {
  for (const std::string& name : names) value_of("--effects", [&] { return normalized_cause(arm, name); });
}

// The command line that designs the next recording, with the robot as the user named it and with the recordings
// and values known so far.
std::string next_command(const DiagnoseRequest& request, const Model& arm,
                         const NextExperiment& next) {
  if (next.between.empty() && next.shows.empty()) return "";
  std::vector<std::string> words = {"veridyn", "excite", request.robot, "-o", "next.csv", "--criterion"};
  if (next.between.empty()) {
    words.emplace_back("d-optimal");
    if (!request.model_out.empty()) words[2] = request.model_out;  // its tables count as parameters
  } else {
    words.insert(words.end(), {"discriminate", "--between",
                               to_text(arm, next.between[0]) + "," + to_text(arm, next.between[1])});
  }
  if (next.slow_passes > 0)
    words.insert(words.end(), {"--slow-passes", std::to_string(next.slow_passes)});
  if (next.between.empty()) return cli::command_line(words);
  words.emplace_back("--given");
  words.insert(words.end(), request.train.begin(), request.train.end());
  const std::vector<std::string> reading =
      options_for_given(request.options.identification.preprocessing, request.common.fixed);
  words.insert(words.end(), reading.begin(), reading.end());
  if (!request.model_out.empty()) words.insert(words.end(), {"--model", request.model_out});
  return cli::command_line(words);
}

Diagnosis diagnosed(const DiagnoseRequest& request, const Model& arm) {
  const IdentificationOptions& how = request.options.identification;
  if (!are_rest_poses(request.rest, arm, request.train, how.preprocessing))
    return diagnose(arm, request.train, request.test, request.options);
  if (!request.test_rows) warn_of_shared_recordings(request.train, request.test);
  const auto [train, test] = read_poses(request.rest, arm, request.train, request.test, how);
  return diagnose(arm, train, test, request.options);
}

ExitStatus run(DiagnoseRequest& request, const std::string& command_line) {
  expect_known_effects(request.options.effects);
  require_writable(request.common.json, request.common.report, request.model_out);
  expect_simulation_of("--model-out", request.model_out, request.robot);
  const Model arm = read_robot(request.robot, request.common, &request.options.identification.preprocessing.signals);
  expect_known_places(arm, request.options.effects);
  warn_of_repeated_recordings(request.train);
  if (!request.values.empty())
    request.options.values = request.values == "prior" ? RobotValues::kPrior : RobotValues::kFacts;
  IdentificationOptions& how = request.options.identification;
  how.threads = request.common.threads;
  how.progress = progress(request.common);
  if (request.test_rows) {
    how.test_preprocessing = how.preprocessing;
    how.test_preprocessing->first_row = request.test_rows->first;
    how.test_preprocessing->row_count = request.test_rows->count;
  }
  Diagnosis d = diagnosed(request, arm);
  d.small_apart = request.small_apart;
  if (!d.baseline.model) {
    print_message(d.baseline.reason);
    return kDataCannotAnswer;
  }
  report_facts(d.data_quality);
  const std::string next = next_command(request, arm, d.next_experiment);
  if (is_simulation_file(request.model_out)) {
    save_as_simulation(*d.extended.model, request.robot, request.model_out, request.common.quiet);
  } else if (!request.model_out.empty()) {
    save(d.extended, request.model_out, "diagnose", robot_path(request.robot));
  }
  if (!request.common.json.empty()) write_file(request.common.json, to_json(d, next));
  if (!request.common.report.empty()) {
    write_file(request.common.report, to_page(d, command_line, next));
  }
  std::cout << d.report(next);
  return d.has_answer() ? kDone : kDataCannotAnswer;
}

}  // namespace

void add_diagnose_command(CLI::App& tool, Outcome& outcome) {
  const auto request = std::make_shared<DiagnoseRequest>();
  CLI::App& command =
      *tool.add_subcommand("diagnose", "Name the causes of a model's error and extend the model");
  add_robot_argument(command, request->robot);
  add_value(command, "--train REC...", request->train, "Training recordings")->required();
  add_value(command, "--test REC...", request->test,
            "Held-out recordings, on which the gain is measured; of a robot file, what they contradict is no finding")
      ->required();
  add_value(command, "--effects EFFECT[:PLACE],...", request->options.effects,
            "Test these effects only, at every joint or at one")
      ->delimiter(',');
  command.add_option("--max-effects", request->options.max_effects, "Largest number of findings")
      ->check(CLI::Range(0, 100));
  command.add_flag_callback(
      "--confirmed-only", [request] { request->small_apart = true; },
      "List the findings that together explain nine tenths, and count the others (the default)");
  command.add_flag_callback(
      "--all-findings", [request] { request->small_apart = false; },
      "List every finding, also the small ones");
  command.add_flag_callback(
      "--keep-unnamed", [request] { request->options.unnamed = UnnamedForces::kKept; },
      "Write unnamed findings into the extended model, as tabulated forces");
  add_value(command, "--values facts|prior", request->values,
            "Meaning of values in the robot file: facts of a MODEL, from which changes are sought, "
            "or a prior that is identified first (default for URDF, MJCF and SDF)",
            CLI::IsMember({"facts", "prior"}));
  add_friction_option(command, request->options.identification.friction);
  add_output_option(command, "--model-out", request->model_out,
                    "Write the extended model as YAML, or into a copy of an MJCF or SDF robot (.xml, .sdf)",
                    {".yaml", ".yml", ".xml", ".mjcf", ".sdf"});
  add_choice(command, "--weights", request->options.identification.weights,
             {JointWeights::kResidual, JointWeights::kRange},
             "Weights of the joints: one over the standard deviation of the residual, or over the "
             "range of the torque");
  add_rest_options(command, request->rest, "name springs and cables beside gravity");
  add_preprocessing_options(command, request->options.identification.preprocessing);
  add_robot_options(command, request->common);
  add_row_range(command, "--test-rows", "Samples of the held-out recordings (default: as --rows)",
                [request](RowRange rows) { request->test_rows = rows; });
  add_common_options(command, request->common);
  add_report_option(command, request->common);
  command.callback([request, &outcome] { outcome.status = run(*request, outcome.command_line); });
}

}  // namespace veridyn::cli
