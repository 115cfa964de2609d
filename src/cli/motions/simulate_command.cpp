#include <fmt/format.h>

#include <iostream>
#include <memory>
#include <set>

#include "cli/commands.hpp"
#include "cli/motions/simulate_request.hpp"
#include "veridyn/tool/common_options.hpp"
#include "veridyn/tool/messages.hpp"
#include "veridyn/tool/option_checks.hpp"
#include "tool/recording_options.hpp"
#include "veridyn/tool/sound_arguments.hpp"
#include "kinematics/motion_limits.hpp"
#include "files/output_file.hpp"
#include "model/suggestion.hpp"
#include "simulation/rotors_at_zero.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/recordings/recording.hpp"
#include "veridyn/recordings/recording_quality.hpp"
#include "veridyn/report/motion_json.hpp"
#include "veridyn/simulation/engine.hpp"
#include "veridyn/simulation/plant.hpp"
#include "veridyn/simulation/plausible_model.hpp"
#include "veridyn/simulation/resampled_motion.hpp"
#include "veridyn/simulation/simulate_recording.hpp"

namespace veridyn::cli {
namespace {

// Reads a wanted motion without repairing its rows.
MotionSamples wanted_motion(const Model& arm, const std::string& path) {
  RecordingOptions reading = recording_options_for(arm, {});
  reading.signals.as_recorded = true;
  const Recording rows = read_recording(path, reading);
  try {
    return with_derivatives({rows.time, rows.q, rows.dq, rows.ddq});
  } catch (const InvalidInput& error) {
    throw InvalidInput(text(path, ": ", error.what()));
  }
}

// Warns of a motion far beyond the limits of the robot file, and of contradictory units.
void warn_of_impossible_motion(const Model& arm, const std::string& path, const MotionSamples& motion) {
  std::vector<std::string> ranges, speeds;
  for (int i = 0; i < arm.joints(); ++i) {
    const Coordinate& c = arm.coordinates()[i];
    const double low = motion.q.col(i).minCoeff(), high = motion.q.col(i).maxCoeff(), fastest = motion.dq.col(i).cwiseAbs().maxCoeff();
    const std::string unit = position_unit(c);
    const double far = 0.5 * (c.limits.upper - c.limits.lower);
    if (high > c.limits.upper + far || low < c.limits.lower - far)
      ranges.push_back(fmt::format("{} goes from {:.4g} to {:.4g} {} (limits {:.4g} to {:.4g})", c.name, low, high, unit, c.limits.lower, c.limits.upper));
    if (fastest > 2.0 * c.limits.velocity)
      speeds.push_back(fmt::format("{} is as fast as {:.4g} {}/s (limit {:.4g})", c.name, fastest, unit, c.limits.velocity));
  }
  for (const std::vector<std::string>* list : {&ranges, &speeds})
    if (!list->empty()) print_message("warning: " + path + ": the motion is far beyond the limits of " + arm.name() + ": " + listed(*list) + ".");
  Recording rows;
  rows.source = path;
  rows.time = motion.time;
  rows.q = motion.q;
  rows.dq = motion.dq;
  std::set<QualityKind> said;  // each kind of finding is reported once
  for (const QualityFinding& f : check_recording(rows).findings) {
    if (f.severity != Severity::kFault || f.signal == "tau" || !said.insert(f.kind).second) continue;
    const size_t advice = f.sentence.find("; --");  // begins advice on options that a trajectory does not have
    print_message("warning: " + path + ": " + f.sentence.substr(0, advice) + (advice == std::string::npos ? "" : "."));
  }
}

// Plausible values are reported after the motion is read, so that the error for a bad file is the only line.
Model arm_with_values(const SimulateRequest& request, std::string& made_up_words) {
  PlausibleModel plausible = plausible_model(read_robot(request.robot, request.common), request.arm_seed);
  const bool made_up = plausible.bodies + plausible.effects > 0;
  require(!made_up || request.replay.empty(), "simulate --replay: robot '", request.robot,
          "' has no values; expected a MODEL that identify or diagnose wrote.");
  if (made_up && !request.common.quiet) {
    made_up_words =
        fmt::format("{} has no values for {} bodies and {} effects: they get plausible ones "
                    "(--arm-seed {}); --model-out writes them.",
                    request.robot, plausible.bodies, plausible.effects, request.arm_seed);
  }
  return plausible.arm;
}

// Gives rotors without inertia a small one, because forward dynamics needs it.
Model movable_arm(const SimulateRequest& request, const Model& arm) {
  const MovableArm movable = with_movable_rotors(arm);
  for (const std::string& one : movable.changed) {
    if (!request.common.quiet) print_message(one + ".");
  }
  return movable.arm;
}

// A motion of steps that start from the middle of the joints' ranges.
MotionSamples wanted_steps(const Model& arm, const std::vector<double>& steps) {
  expect_value(static_cast<int>(steps.size()) == arm.joints(), "--steps", "found ", steps.size(),
               " numbers, expected ", arm.joints(), ", one per joint of ", arm.name());
  const MotionLimits limits = motion_limits(arm);
  return joint_steps(
      0.5 * (limits.lower + limits.upper),
      Eigen::Map<const VectorXd>(steps.data(), static_cast<Eigen::Index>(steps.size())));
}

ExitStatus run(const SimulateRequest& request, const std::string& command_line) {
  check_simulate_request(request);
  require_writable(request.output, request.model_out, request.common.json, request.common.report);
  SimulationOptions options;
  options.noise = sensor_noise(request.noise);
  options.seed = request.seed;
  for (const std::string& asked : request.effects) {
    if (asked == "none") continue;
    options.hidden.push_back(value_of("--effect", [&] { return parse_hidden_effect(asked); }));
  }
  std::string made_up_words;
  Model arm = arm_with_values(request, made_up_words);
  if (!request.replay.empty() || request.controller != "none") arm = movable_arm(request, arm);
  if (!request.breakaway.empty()) return run_breakaway(request, arm, command_line);
  if (!request.replay.empty()) return run_replay(request, arm, command_line);
  value_of("--effect", [&] { inject_effects(arm, options.hidden); });
  MotionSamples wanted = request.steps.empty() ? wanted_motion(arm, request.trajectory)
                                               : wanted_steps(arm, request.steps);
  require(wanted.q.cols() == arm.joints(), request.trajectory, ": found ", wanted.q.cols(),
          " joints, expected the ", arm.joints(), " of ", arm.name(), ".");
  for (Eigen::Index k = 0; k < wanted.q.rows(); ++k)
    require(wanted.q.row(k).allFinite(), request.trajectory, ": found a gap in the positions of row ", k,
            " (the first is 0), expected none in a motion.");
  if (!made_up_words.empty()) print_message(made_up_words);
  if (request.steps.empty()) warn_of_impossible_motion(arm, request.trajectory, wanted);
  if (request.sample_rate > 0.0)
    wanted = value_of("--sample-rate", [&] { return resampled(wanted, request.sample_rate); });
  if (request.controller != "none")
    return run_controlled(request, arm, wanted, options, command_line);
  const std::string trouble = infeasibility(arm);
  if (!trouble.empty()) print_message("warning: " + trouble);
  const SimulatedRecording simulated = while_busy(
      request.common, "simulating", [&] { return simulate_recording(arm, wanted, options); });
  write_simulated(request, simulated);
  if (!request.common.json.empty()) write_file(request.common.json, to_json(simulated));
  std::cout << simulation_report(request, simulated);
  return kDone;
}

std::string presets_help() {
  std::string out = "Noise presets (turning joints / sliding joints):\n";
  for (const std::string& name : sensor_noise_names()) {
    const std::string words = name == "none" ? "ideal" : describe(sensor_noise(name));
    out += fmt::format("  {:<5} {}\n", name, words);
  }
  out +=
      "KEYs of noise, in seconds and shares: stale_rows, stale_run (rows), dropouts, dropout_run\n"
      "(rows), delay, late, torque_white, torque_coloured.\n"
      "Effects: JOINT is a coordinate's name or its number from 1; KEY is a parameter or a shape\n"
      "constant of the effect, and from=JOINT for couplings. Parameters that are not given make\n"
      "10 % of the joint's rms effort. Of other kinds:\n"
      "  payload:FRAME:mass=KG,x=M,y=M,z=M       gravity_tilt:arm:roll=RAD,pitch=RAD\n"
      "  torque_gain:JOINT:gain=X                time_delay:JOINT:seconds=S\n"
      "  encoder_offset:JOINT:offset=RAD         external_contact:JOINT:from=S,to=S,effort=NM\n"
      "  coupling_error:CONSTANT:change=X        (a constant of the robot file)\n"
      "  base_compliance:arm:about_x=X,about_y=X (rad/(N m))\n"
      "  tip_force:arm:x=N,y=N,z=N               (at the end of the arm, along the base's axes)\n"
      "  torque_crosstalk:JOINT:from=JOINT,share=X";
  return out;
}

}  // namespace

void add_simulate_command(CLI::App& tool, Outcome& outcome) {
  const auto request = std::make_shared<SimulateRequest>();
  CLI::App& command = *tool.add_subcommand(
      "simulate", "Simulate the recording of an arm, with faults of your choice");
  request->command = &command;
  add_robot_argument(command, request->robot);
  add_value(command, "--trajectory TRAJ", request->trajectory,
            "CSV file with t and q, optionally dq and ddq");
  add_value(command, "--steps X,X,...", request->steps,
            "In place of a trajectory: one joint after the other steps by this, each over 1 s")
      ->delimiter(',');
  add_output_option(command, "-o,--output", request->output, "Write the recording as CSV: t, q, dq, tau", {".csv"});
  add_value(command, "--effect NAME:JOINT[:KEY=VALUE,...]", request->effects,
            "Add an effect that the robot file lacks; see below")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command.add_option("--noise", request->noise, "Preset of sensor noise; see below (low)")
      ->option_text(listed(sensor_noise_names()) + "[:KEY=VALUE,...]")
      ->check(CLI::Validator(
          [](const std::string& asked) {
            try {
              sensor_noise(asked);
            } catch (const InvalidInput& error) {
              return std::string(error.what());
            }
            return std::string();
          },
          ""));
  add_value(command, "--sample-rate HZ", request->sample_rate,
            "Sample rate of the recording (default: that of the trajectory)", CLI::PositiveNumber);
  command.add_option("--engine", request->engine, "Simulation engine (veridyn)")
      ->option_text(listed(engine_names()));
  add_value(command, "--seed N", request->seed, "Random seed of the noise (1)");
  add_value(command, "--arm-seed N", request->arm_seed,
            "Random seed of plausible parameters for a robot file without values (1)");
  add_output_option(command, "--model-out", request->model_out,
                    "Write the simulated arm's true model as YAML");
  add_control_options(command, *request);
  add_common_options(command, request->common);
  add_report_option(command, request->common);
  command.footer(presets_help());
  command.callback([request, &outcome] { outcome.status = run(*request, outcome.command_line); });
}

}  // namespace veridyn::cli
