#include <algorithm>
#include <cstdio>
#include <iostream>
#include <memory>
#include <optional>

#include "veridyn/tool/choice.hpp"
#include "cli/commands.hpp"
#include "veridyn/tool/common_options.hpp"
#include "veridyn/tool/messages.hpp"
#include "veridyn/tool/option_checks.hpp"
#include "files/output_file.hpp"
#include "cli/identification/ranks.hpp"
#include "tool/recording_options.hpp"
#include "cli/options/rest_options.hpp"
#include "cli/models/simulation_output.hpp"
#include "veridyn/tool/sound_arguments.hpp"
#include "identification/many_recordings.hpp"
#include "veridyn/identification/robot_check.hpp"
#include "veridyn/identification/factor_set.hpp"
#include "veridyn/identification/parameters_text.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/report/pages.hpp"
#include "veridyn/report/json.hpp"
#include "recordings/named_recordings.hpp"
#include "veridyn/report/setting_names.hpp"

namespace veridyn::cli {
namespace {

struct IdentifyRequest {
  const CLI::App* command = nullptr;  // the command whose options were given
  std::string robot;
  std::vector<std::string> train, test, factors;
  std::string factor_out;
  std::optional<RowRange> test_rows;
  std::string prior;
  std::vector<std::string> known_masses;
  std::string model_out;
  bool parameters = false;
  RestRequest rest;
  IdentificationOptions options;
  CommonOptions common;
};

IdentificationOptions identification_options(const IdentifyRequest& request) {
  IdentificationOptions options = request.options;
  options.choose_velocities = request.command->count("--velocity") == 0;
  options.threads = request.common.threads;
  options.progress = progress(request.common);
  if (!request.prior.empty()) {
    options.prior = read_model(request.prior);
    expect_value(options.prior->inertial_values().has_value(), "--prior",
                 "found bodies without values in '", options.prior->name(),
                 "', expected a model with values, as from CAD or identify");
  }
  for (const std::string& asked : request.known_masses)
    options.known_masses.push_back(
        value_of("--known-mass", [&] { return parse_known_mass(asked); }));
  if (request.test_rows) {
    options.test_preprocessing = options.preprocessing;
    options.test_preprocessing->first_row = request.test_rows->first;
    options.test_preprocessing->row_count = request.test_rows->count;
  }
  return options;
}

bool needs_samples(const IdentifyRequest& request) {
  return request.options.method == Method::kIv || request.options.method == Method::kDidim;
}

void expect_effective_options(const IdentifyRequest& request) {
  const bool feasible = request.options.method == Method::kFeasible;
  expect_prerequisites(*request.command,
                       {{"--prior", feasible, "--method feasible"},
                        {"--condition", feasible, "--method feasible"},
                        {"--signs", feasible, "--method feasible"},
                        {"--weights", request.options.method != Method::kOls, "a method other than ols"},
                        {"--test-rows", !request.test.empty(), "--test"}});
  expect_value(!request.train.empty() || !request.factors.empty(), "--train",
               "found no recording, expected some, or factor files of them after --factors");
  expect_value(!needs_samples(request) || (request.factors.empty() && request.factor_out.empty()), "--method",
               "found '", name_of(request.options.method), "' with factors, expected recordings alone: it needs their samples");
  expect_value(request.factors.empty() || request.known_masses.empty(), "--factors",
               "found with --known-mass, expected recordings: drive gains need their samples");
  for (const std::string& asked : request.known_masses)
    value_of("--known-mass", [&] { return parse_known_mass(asked); });
  expect_value(request.known_masses.empty() || request.train.size() > 1, "--known-mass",
               "found one recording, expected one at least with the load and one without");
}

// Checks that the frames exist and the recordings are training recordings.
void expect_known_masses(const IdentifyRequest& request, const Model& arm,
                         const std::vector<KnownMass>& masses) {
  std::vector<std::string> recordings = request.train;
  for (const std::string& path : request.train)
    recordings.push_back(path.substr(path.find_last_of('/') + 1));
  for (const KnownMass& mass : masses) {
    expect_one_of("--known-mass", mass.frame, frame_names(arm));
    for (const std::string& name : mass.recordings) expect_one_of("--known-mass", name, recordings);
  }
}

FactorSet read_all_factors(const std::vector<std::string>& paths) {
  FactorSet out;
  for (const std::string& path : paths) {
    try {
      out = merge(std::move(out), read_factors(path));
    } catch (const InvalidInput& e) {
      const std::string what = e.what();
      if (what.compare(0, path.size(), path) == 0) throw;
      throw InvalidInput(path + ": " + what);
    }
  }
  return out;
}

Identification identified_at_rest(const IdentifyRequest& request, const Model& arm,
                                  const IdentificationOptions& options) {
  expect_value(!needs_samples(request), "--method", "found '", name_of(request.options.method),
               "' with poses at rest, expected ols, wls or feasible: nothing moves there");
  expect_value(request.factors.empty() && request.factor_out.empty() && request.known_masses.empty(),
               "--at-rest", "found with factors or known masses, expected recordings of poses alone");
  const auto [train, test] = read_poses(request.rest, arm, request.train, request.test, options);
  return identify(arm, train, test, options);
}

// The factors of the training recordings. Velocities are chosen as identify() does, or as in the factors that
// were given with them.
FactorSet compressed(const IdentifyRequest& request, const Model& arm,
                     const IdentificationOptions& options) {
  FactorSet factors = read_all_factors(request.factors);
  if (request.factor_out.empty()) return factors;
  PreprocessingOptions how = options.preprocessing;
  if (!request.factors.empty() && options.choose_velocities) {
    how.derive_velocity_of = joints_with_derived_velocities(factors);
  } else if (options.choose_velocities) {
    const Identification alone = identify(arm, request.train, {}, options);
    how.derive_velocity_of = alone.preprocessing.derive_velocity_of;
    for (const std::string& remark : alone.remarks) print_message(remark);
  }
  const FactorSet fresh =
      compress(with_friction(arm, options.friction), request.train, how, options.threads);
  factors = merge(std::move(factors), fresh);
  save_factors(factors, request.factor_out);
  return factors;
}

// Identifies the arm; --factor-out writes the factors even if they do not determine a model.
Identification identified(const IdentifyRequest& request, const Model& arm,
                          const IdentificationOptions& options) {
  if (request.factors.empty() && request.factor_out.empty())
    return identify(arm, request.train, request.test, options);
  const FactorSet factors = compressed(request, arm, options);
  const bool all_in = !request.factor_out.empty();
  return identify(arm, factors, all_in ? std::vector<std::string>() : request.train, request.test,
                  options);
}

void write_results(const IdentifyRequest& request, const Identification& id,
                   const std::string& command_line) {
  if (id.status == IdentificationStatus::kNotConverged) print_message("warning: " + id.reason);
  if (is_simulation_file(request.model_out)) {
    save_as_simulation(*id.model, request.robot, request.model_out, request.common.quiet);
  } else if (!request.model_out.empty()) {
    save(id, request.model_out, "identify", robot_path(request.robot));
  }
  if (!request.common.json.empty()) write_file(request.common.json, to_json(id));
  if (!request.common.report.empty()) {
    const Model robot = read_model(request.robot);
    write_file(request.common.report, to_page(id, command_line, &robot));
  }
  std::cout << id.report();
  if (request.parameters) std::cout << parameters_text(id);
}

// Path of the file for the factors of one rank, in the folder of the requested file.
std::string part_of(const IdentifyRequest& request, const Communicator& ranks) {
  return text(request.factor_out, ".rank-", ranks.rank());
}

Identification identified_by_ranks(const IdentifyRequest& request, const Model& arm,
                                   const IdentificationOptions& options, Communicator& ranks) {
  KeepFactors keep;
  if (!request.factor_out.empty()) {
    keep = [&](const FactorSet& factors, bool whole) {
      save_factors(factors, whole ? request.factor_out : part_of(request, ranks));
    };
  }
  print_on_abort(
      text("rank ", ranks.rank(), ": another rank was lost and the work ends here; ",
           keep ? "what this one has done is in " + part_of(request, ranks)
                : std::string("with --factor-out what was done would have been kept"),
           "."));
  Identification id = identify(arm, request.train, request.test, options, ranks, keep);
  if (keep) std::remove(part_of(request, ranks).c_str());
  return id;
}

// Runs on every rank; only the first one prints.
ExitStatus run_on_ranks(IdentifyRequest& request, const std::string& command_line,
                        Communicator& ranks) {
  const bool first = ranks.rank() == 0;
  try {
    expect_value(!needs_samples(request), "--method", "found '", name_of(request.options.method),
                 "' under mpirun, expected ols, wls or feasible: ranks share factors alone");
    expect_value(request.factors.empty(), "--factors",
                 "found under mpirun, expected recordings to spread over the ranks");
    const Model arm = read_robot(request.robot, request.common, &request.options.preprocessing.signals);
    IdentificationOptions options = identification_options(request);
    options.threads = threads_of_a_rank(request.common.threads);
    if (!first) options.progress = nullptr;
    const Identification id = identified_by_ranks(request, arm, options, ranks);
    if (!first) return kDone;  // only the first rank has the result and its status
    for (const UnusedRecording& r : id.unusable_recordings) print_message("warning: left out: " + r.why);
    if (id.parameters.size() == 0) {
      print_message(id.reason);
      return kDataCannotAnswer;
    }
    write_results(request, id, command_line);
    return kDone;
  } catch (const InvalidInput& error) {
    if (first) print_message(error.what());
    end_all_ranks(kBadInput);
  } catch (const CLI::Error&) {
    throw;  // this exception is thrown on all ranks
  } catch (const std::exception& error) {
    print_message(text("rank ", ranks.rank(), ": internal fault: ", error.what()));
    end_all_ranks(kProgramFault);
  }
}

ExitStatus run(IdentifyRequest& request, const std::string& command_line) {
  const std::unique_ptr<Communicator> ranks = mpi_ranks();
  expect_effective_options(request);
  require_writable(request.common.json, request.common.report, request.model_out);
  expect_simulation_of("--model-out", request.model_out, request.robot);
  require_writable(request.factor_out);
  if (ranks && ranks->size() > 1) return run_on_ranks(request, command_line, *ranks);
  const Model arm = read_robot(request.robot, request.common, &request.options.preprocessing.signals);
  IdentificationOptions options = identification_options(request);
  keep_recordings(options, KeptRecordings::kFewPasses);
  expect_known_masses(request, arm, options.known_masses);
  warn_of_repeated_recordings(request.train);
  std::vector<std::string> recordings = request.train;
  recordings.insert(recordings.end(), request.test.begin(), request.test.end());
  const bool poses = request.rest.at_rest || !request.rest.approach.empty() ||
                     (request.factors.empty() && are_rest_poses(request.rest, arm, request.train, options.preprocessing));
  if (poses && !request.test_rows) warn_of_shared_recordings(request.train, request.test);
  if (!poses) check_recordings(arm, recordings, options.preprocessing, options.threads);
  Identification id = poses ? identified_at_rest(request, arm, options) : identified(request, arm, options);
  if (!id.model) {
    if (id.drive_gains && id.drive_gains->problem.empty()) std::cout << id.drive_gains->report();
    if (id.drive_gains && !request.common.json.empty())
      write_file(request.common.json, to_json(id));
    print_message(id.reason);
    return kDataCannotAnswer;
  }
  if (!poses) {
    for (const QualityFinding& f : contradictions_in(arm, request.train, request.test, options.preprocessing, id))
      id.remarks.push_back(f.file + ": " + f.sentence);
  }
  write_results(request, id, command_line);
  return kDone;
}

void add_fit_options(CLI::App& command, IdentifyRequest& request) {
  IdentificationOptions& options = request.options;
  add_choice(command, "--method", options.method, {Method::kOls, Method::kWls, Method::kFeasible, Method::kIv, Method::kDidim},
             "Ordinary or weighted least squares, or weighted and physically consistent; iv and didim: with the motion "
             "without noise as instruments, or in place of the measured one, and the Durbin-Wu-Hausman test of each joint");
  add_choice(command, "--weights", options.weights, {JointWeights::kRange, JointWeights::kResidual},
             "Weights of the joints: one over the range of the torque, or over the standard "
             "deviation of the residual");
  add_choice(command, "--condition", options.condition,
             {PhysicalCondition::kPseudoInertia, PhysicalCondition::kPrincipalMoments},
             "Condition of physical consistency, with --method feasible");
  add_choice(command, "--signs", options.signs, {EffectSigns::kPhysical, EffectSigns::kAny},
             "Signs of friction, inertia and stiffness, with --method feasible");
  add_friction_option(command, options.friction);
  add_value(command, "--prior MODEL", request.prior,
            "Prior model (CAD) for parameters that the data leave open, with --method feasible");
  add_value(command, "--known-mass KG@FRAME[=REC,REC]", request.known_masses,
            "Find the drive gains of an arm that reports motor currents: a mass of KG is mounted "
            "on FRAME in the training recordings REC (default: the data decide which)")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

}  // namespace

void add_identify_command(CLI::App& tool, Outcome& outcome) {
  const auto request = std::make_shared<IdentifyRequest>();
  CLI::App& command =
      *tool.add_subcommand("identify", "Identify the dynamic parameters of an arm from recordings");
  request->command = &command;
  add_robot_argument(command, request->robot);
  add_value(command, "--train REC...", request->train, "Training recordings");
  add_value(command, "--factors FILE...", request->factors, "Factor files to use as training data");
  add_output_option(
      command, "--factor-out", request->factor_out,
      "Write the information of the training recordings as a factor file, which holds no samples");
  add_value(command, "--test REC...", request->test, "Held-out recordings for validation");
  add_fit_options(command, *request);
  add_output_option(command, "--model-out", request->model_out,
                    "Write the identified model as YAML, or into a copy of an MJCF or SDF robot (.xml, .sdf)",
                    {".yaml", ".yml", ".xml", ".mjcf", ".sdf"});
  command.add_flag("--parameters", request->parameters, "Print the base parameters with their deviations, too");
  add_rest_options(command, request->rest, "identify gravity, offsets and forces of position from them");
  add_preprocessing_options(command, request->options.preprocessing);
  add_robot_options(command, request->common);
  add_row_range(command, "--test-rows", "Samples of the held-out recordings (default: as --rows)",
                [request](RowRange rows) { request->test_rows = rows; });
  add_common_options(command, request->common);
  add_report_option(command, request->common);
  command.callback([request, &outcome] { outcome.status = run(*request, outcome.command_line); });
}

}  // namespace veridyn::cli
