#include <fmt/format.h>

#include <iostream>
#include <memory>

#include "commands.hpp"
#include "common_options.hpp"
#include "messages.hpp"
#include "veridyn/identification/recording.hpp"
#include "veridyn/math/output_file.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/model/model_file.hpp"
#include "veridyn/model/suggestion.hpp"
#include "veridyn/report/motion_json.hpp"
#include "veridyn/simulation/plausible_model.hpp"
#include "veridyn/simulation/simulate_recording.hpp"

namespace veridyn::cli {
namespace {

struct Request {
  std::string robot;
  std::string trajectory;
  std::string output;
  std::vector<std::string> effects;
  std::string noise = "low";
  std::string engine = "veridyn";
  std::string model_out;
  unsigned seed = 1;
  unsigned arm_seed = 1;
  CommonOptions common;
};

MotionSamples wanted_motion(const std::string& path) {
  const Recording rows = read_recording(path);
  try {
    return with_derivatives({rows.time, rows.q, rows.dq, rows.ddq});
  } catch (const InvalidInput& error) {
    throw InvalidInput(text(path, ": ", error.what()));
  }
}

Model arm_with_values(const Request& request) {
  PlausibleModel plausible = plausible_model(read_model(request.robot), request.arm_seed);
  if (plausible.bodies + plausible.effects > 0 && !request.common.quiet) {
    say(
        fmt::format("{} has no values for {} bodies and {} effects: they get plausible ones "
                    "(--arm-seed {}); --model-out writes them.",
                    request.robot, plausible.bodies, plausible.effects, request.arm_seed));
  }
  return plausible.arm;
}

std::string report(const Request& request, const SimulatedRecording& simulated) {
  const MotionSamples& m = simulated.measured;
  std::string out =
      fmt::format("Simulated {}: {} rows, {:.4g} s, noise {}.\n", simulated.truth.name(), m.rows(),
                  m.time[m.rows() - 1] - m.time[0], request.noise);
  for (const PlantedEffect& planted : simulated.planted) {
    out += fmt::format("Hidden: {} on {}", planted.effect, planted.place);
    if (planted.joint > 0) out += fmt::format(" (joint {})", planted.joint);
    for (const auto& [key, value] : planted.values) out += fmt::format(", {} {:.5g}", key, value);
    out += ".\n";
  }
  return out;
}

ExitStatus run(const Request& request) {
  if (request.engine != "veridyn") {
    throw CLI::ValidationError("--engine", "found '" + request.engine + "', expected veridyn");
  }
  for (const std::string& path : {request.output, request.model_out, request.common.json}) {
    require_writable(path);
  }
  SimulationOptions options;
  options.noise = sensor_noise(request.noise);
  options.seed = request.seed;
  for (const std::string& asked : request.effects) {
    if (asked != "none") options.hidden.push_back(parse_hidden_effect(asked));
  }
  const Model arm = arm_with_values(request);
  const MotionSamples wanted = wanted_motion(request.trajectory);
  require(wanted.q.cols() == arm.joints(), request.trajectory, ": found ", wanted.q.cols(),
          " joints, expected the ", arm.joints(), " of ", arm.name(), ".");
  const SimulatedRecording simulated = simulate_recording(arm, wanted, options);
  Recording rows;
  rows.time = simulated.measured.time;
  rows.q = simulated.measured.q;
  rows.dq = simulated.measured.dq;
  rows.tau = simulated.tau;
  write_recording(rows, request.output);
  if (!request.model_out.empty()) save_model(simulated.truth, request.model_out);
  if (!request.common.json.empty()) write_file(request.common.json, to_json(simulated));
  std::cout << report(request, simulated);
  return kDone;
}

std::string footer() {
  std::string out = "Noise presets (turning joints / sliding joints):\n";
  for (const std::string& name : sensor_noise_names()) {
    const std::string words = name == "none" ? "ideal" : describe(sensor_noise(name));
    out += fmt::format("  {:<5} {}\n", name, words);
  }
  out +=
      "Effects: JOINT is a coordinate's name or its number from 1; KEY is a parameter or a shape\n"
      "constant of the effect, and from=JOINT for couplings. Parameters that are not given make\n"
      "10 % of the joint's rms effort. Of other kinds:\n"
      "  payload:FRAME:mass=KG,x=M,y=M,z=M       gravity_tilt:arm:roll=RAD,pitch=RAD\n"
      "  torque_gain:JOINT:gain=X                time_delay:JOINT:seconds=S\n"
      "  encoder_offset:JOINT:offset=RAD         external_contact:JOINT:from=S,to=S,effort=NM\n"
      "  coupling_error:CONSTANT:change=X        (a constant of the robot file)";
  return out;
}

}  // namespace

void add_simulate_command(CLI::App& tool, Outcome& outcome) {
  const auto request = std::make_shared<Request>();
  CLI::App& command =
      *tool.add_subcommand("simulate", "A recording of an arm along a motion, with hidden effects");
  add_robot_argument(command, request->robot);
  command.add_option("--trajectory", request->trajectory, "CSV with t and q; dq and ddq if there")
      ->required()
      ->option_text("TRAJ");
  command.add_option("-o,--output", request->output, "Write the recording as CSV: t, q, dq, tau")
      ->required()
      ->option_text("FILE");
  command.add_option("--effect", request->effects, "What the arm has beyond its file; see below")
      ->option_text("NAME:JOINT[:KEY=VALUE,...]")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command.add_option("--noise", request->noise, "Sensors and controller; see below (low)")
      ->option_text(listed(sensor_noise_names()))
      ->check(CLI::IsMember(sensor_noise_names()));
  command.add_option("--engine", request->engine, "What computes the rigid bodies (veridyn)")
      ->option_text("veridyn");
  command.add_option("--seed", request->seed, "Of the noise (1)")->option_text("N");
  command
      .add_option("--arm-seed", request->arm_seed,
                  "Of the values of an arm whose file has none; the same in all its recordings (1)")
      ->option_text("N");
  command.add_option("--model-out", request->model_out, "Write the true arm as YAML")
      ->option_text("FILE");
  add_common_options(command, request->common);
  command.footer(footer());
  command.callback([request, &outcome] { outcome.status = run(*request); });
}

}  // namespace veridyn::cli
