#include <fmt/format.h>

#include <algorithm>
#include <iostream>

#include "veridyn/tool/messages.hpp"
#include "veridyn/tool/option_checks.hpp"
#include "tool/recording_options.hpp"
#include "cli/motions/simulate_request.hpp"
#include "veridyn/recordings/preprocessing.hpp"
#include "files/output_file.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/report/motion_json.hpp"
#include "report/pages/simulation_page.hpp"

namespace veridyn::cli {
namespace {

const char* const kControl = "Control";
constexpr double kFrequency = 20.0;  // [rad/s] double pole of the error under computed torque

VectorXd per_joint(const std::vector<double>& numbers, const Model& arm, const char* option) {
  if (numbers.empty()) return {};
  expect_value(static_cast<int>(numbers.size()) == arm.joints(), option, "found ", numbers.size(),
               " numbers, expected ", arm.joints(), ", one per joint of ", arm.name());
  const bool limits = std::string(option) == "--torque-limit";
  for (const double x : numbers)
    expect_value(x > 0.0 || (x == 0.0 && !limits), option, "found ", x, ", expected ",
                 limits ? "numbers above zero" : "no number below zero");
  return Eigen::Map<const VectorXd>(numbers.data(), arm.joints());
}

}  // namespace

LoopOptions control_loop_options(const SimulateRequest& request, const Model& arm) {
  LoopOptions loop = request.loop;
  if (request.controller == "computed-torque") {
    const auto n = static_cast<Eigen::Index>(arm.joints());
    loop.model = std::make_shared<const Model>(
        request.controller_model.empty() ? arm
                                         : read_robot(request.controller_model, request.common));
    loop.gains = {VectorXd::Constant(n, kFrequency * kFrequency), VectorXd::Zero(n),
                  VectorXd::Constant(n, 2.0 * kFrequency)};
  }
  loop.drive.limit = per_joint(request.limit, arm, "--torque-limit");
  if (!request.gains.empty()) loop.gains = read_gains(request.gains, arm);
  if (request.p.empty()) return loop;
  loop.gains.p = per_joint(request.p, arm, "--kp");
  loop.gains.i = request.i.empty() ? VectorXd(VectorXd::Zero(arm.joints()))
                                   : per_joint(request.i, arm, "--ki");
  const auto critical = [&] {
    return loop.model ? VectorXd(2.0 * loop.gains.p.cwiseSqrt())
                      : critical_damping(arm, loop.gains.p);
  };
  loop.gains.d = request.d.empty() ? critical() : per_joint(request.d, arm, "--kd");
  return loop;
}

Recording rows_of(const MotionSamples& motion, const MatrixXd& tau) {
  Recording rows;
  rows.time = motion.time;
  rows.q = motion.q;
  rows.dq = motion.dq;
  rows.tau = tau;
  return rows;
}

void report_omitted_effects(const SimulateRequest& request, const std::vector<std::string>& left_out) {
  if (request.common.quiet) return;
  for (const std::string& one : left_out) print_message("left out: " + one + ".");
}

bool stopped(const EngineRun& run, const Model& arm) {
  if (run.complete()) return false;
  print_message("the run " + run.stop_reason(arm) + "; nothing is written.");
  return true;
}

void add_control_options(CLI::App& command, SimulateRequest& request) {
  const auto numbers = [&](const char* name, std::vector<double>& target, const char* help) {
    command.add_option(name, target, help)->option_text("X,X,...")->delimiter(',')->group(kControl);
  };
  const auto number = [&](const char* name, double& target, const char* unit, const char* help) {
    command.add_option(name, target, help)
        ->option_text(unit)
        ->check(CLI::NonNegativeNumber)
        ->group(kControl);
  };
  add_value(command, "--controller none|pid|computed-torque", request.controller,
            "pid: forward dynamics under a PID per joint; computed-torque: under that law, whose "
            "--kp [1/s^2] and --kd [1/s] are the same for any inertia; none: the arm makes the "
            "motion exactly, its torques by inverse dynamics (none)",
            CLI::IsMember({"none", "pid", "computed-torque"}))
      ->group(kControl);
  add_value(command, "--controller-model MODEL", request.controller_model,
            "What computed torque takes the arm for (the arm without its hidden effects)")
      ->group(kControl);
  number("--friction-share", request.loop.friction, "X",
         "Of the model's friction that computed torque compensates (0)");
  add_value(command, "--replay REC", request.replay,
            "Drive the simulated arm with a recording instead of a trajectory, and compare")
      ->group(kControl);
  add_value(command, "--drive commands|set-points|torques", request.drive,
            "What of the recording drives: the commands that its PD must have had, its motion as "
            "set points, or its torques (commands)",
            CLI::IsMember({"commands", "set-points", "torques"}))
      ->group(kControl);
  add_value(command, "--breakaway JOINT", request.breakaway,
            "With --replay of slow ramps: report the breakaway effort of this joint")
      ->group(kControl);
  number("--breakaway-speed", request.breakaway_speed, "M/S",
         "Speed above which the joint slides (5 mm/s, 50 mrad/s)");
  add_value(command, "--gains FILE", request.gains, "YAML file with lists p, i and d")
      ->group(kControl);
  numbers("--kp", request.p, "Position gains (default: 6 Hz of bandwidth)");
  numbers("--ki", request.i, "Integral gains (default: none with --kp)");
  numbers("--kd", request.d, "Velocity gains (default: critical damping)");
  add_value(command, "--control-rate HZ", request.loop.rate, "Rate of the controller [Hz] (1000)",
            CLI::Range(1.0, 1e6))
      ->group(kControl);
  numbers("--torque-limit", request.limit,
          "Torque limits of the motors (default: the robot file's)");
  number("--current-lag", request.loop.drive.lag, "S", "Time constant of the current loop [s] (0)");
  number("--torque-step", request.loop.drive.step, "NM", "Torque resolution of the amplifiers (0)");
  number("--encoder-delay", request.loop.sensors.delay, "S",
         "Delay of the positions that the controller reads [s] (0)");
  number("--set-point-cutoff", request.set_point_cutoff, "HZ",
         "Low-pass filter of the recorded motion and torque before they are used (default: none)");
  number("--filter-cutoff", request.preprocessing.cutoff, "HZ",
         "Low-pass filter of both torques before comparison [Hz] (5)");
  add_signal_options(command, request.preprocessing.signals);
  add_robot_options(command, request.common);
}

namespace {

std::vector<OptionNeed> simulate_needs(const SimulateRequest& request) {
  const bool replay = !request.replay.empty();
  const bool ramps = !request.breakaway.empty();
  const bool moves = replay || request.controller != "none";
  const bool torque_law = !replay && request.controller == "computed-torque";
  const bool loop = replay ? request.drive != "torques" && !ramps : moves;
  std::vector<OptionNeed> needs = {
      {"--breakaway", replay, "--replay"},
      {"--drive", replay && !ramps, "--replay without --breakaway"},
      {"--breakaway-speed", ramps, "--breakaway"},
      {"--filter-cutoff", replay, "--replay"},
      {"--topic", replay, "--replay"},
      {"--map", replay, "--replay"},
      {"--units", replay, "--replay"},
      {"--set-point-cutoff", replay && loop, "--replay led by commands or set-points"},
      {"--controller-model", torque_law, "--controller computed-torque"},
      {"--friction-share", torque_law, "--controller computed-torque"},
      {"--steps", moves && !replay, "--controller pid or computed-torque"},
      {"--report", moves, "--controller pid or --replay"},
      {"--engine", moves, "--controller pid or --replay"}};
  for (const char* option :
       {"--effect", "--noise", "--sample-rate", "--seed", "--arm-seed", "--model-out"})
    needs.push_back({option, !replay, "--trajectory"});
  for (const char* option : {"--gains", "--kp", "--ki", "--kd", "--control-rate", "--torque-limit",
                             "--current-lag", "--torque-step", "--encoder-delay"})
    needs.push_back({option, loop, "--controller pid, or --replay led by commands or set-points"});
  return needs;
}

}  // namespace

void check_simulate_request(const SimulateRequest& request) {
  const bool motion = !request.trajectory.empty() || !request.steps.empty();
  if (motion != request.replay.empty() || (!request.trajectory.empty() && !request.steps.empty()))
    throw CLI::ValidationError("simulate", "expected one of --trajectory, --steps and --replay");
  if (request.output.empty() && request.replay.empty()) throw CLI::RequiredError("--output");
  expect_prerequisites(*request.command, simulate_needs(request));
  if (!request.gains.empty() && !request.p.empty())
    throw CLI::ValidationError("--gains", "found --kp beside it, expected one of them");
  if (request.p.empty() && (!request.i.empty() || !request.d.empty()))
    throw CLI::ValidationError("--kp", "found --ki or --kd without it");
  expect_one_of("--engine", request.engine, engine_names());
}

void write_simulated(const SimulateRequest& request, const SimulatedRecording& simulated) {
  write_recording(rows_of(simulated.measured, simulated.tau), request.output);
  if (!request.model_out.empty()) save_model(simulated.truth, request.model_out);
}

std::string simulation_report(const SimulateRequest& request, const SimulatedRecording& simulated) {
  const MotionSamples& m = simulated.measured;
  std::string out =
      fmt::format("Simulated {}: {} rows, {:.4g} s, noise {}.\n", simulated.truth.name(), m.rows(),
                  m.time[m.rows() - 1] - m.time[0], request.noise);
  for (const InjectedEffect& injected : simulated.injected) {
    out += fmt::format("Hidden: {} on {}", injected.effect, injected.place);
    if (injected.joint) out += fmt::format(" (joint {})", injected.joint->value + 1);
    for (const auto& [key, value] : injected.values) out += fmt::format(", {} {:.5g}", key, value);
    out += ".\n";
  }
  return out;
}

ExitStatus run_controlled(const SimulateRequest& request, const Model& arm,
                          const MotionSamples& wanted, const SimulationOptions& options,
                          const std::string& command_line) {
  const double lasts = wanted.time[wanted.rows() - 1] - wanted.time[0];
  expect_value(request.loop.sensors.delay < lasts, "--encoder-delay", "found ",
               request.loop.sensors.delay, " s, expected less than the ", lasts,
               " s of the motion");
  const LoopOptions loop = control_loop_options(request, arm);
  const ControlledRecording done = while_busy(request.common, "simulating", [&] {
    return simulate_controlled(arm, wanted, {options, loop, request.engine});
  });
  report_omitted_effects(request, done.left_out);
  if (stopped(done.run, arm)) return kDataCannotAnswer;
  write_simulated(request, done.recording);
  if (!request.common.json.empty()) write_file(request.common.json, to_json(done, wanted));
  std::string report = simulation_report(request, done.recording);
  const MatrixXd& q = done.run.motion.q;
  for (int i = 0; i < arm.joints(); ++i) {
    const Coordinate& c = arm.coordinates()[i];
    const VectorXd off = (q.col(i) - wanted.q.col(i).head(q.rows())).cwiseAbs();
    report += fmt::format("joint {} ({}): at most {:.3g} {} off its set point", i + 1, c.name,
                          1e3 * off.maxCoeff(), c.prismatic ? "mm" : "mrad");
    if (!request.steps.empty()) {  // the step of joint i ends where that of the next joint begins
      const Eigen::Index last = std::min(off.size(), (i + 1) * wanted.rows() / arm.joints()) - 1;
      report += fmt::format(", {:.3g} at the end of its step", 1e3 * off[last]);
    }
    report += "\n";
  }
  if (!request.common.report.empty())
    write_file(request.common.report,
               to_page(done, wanted, {request.trajectory, command_line, report}));
  std::cout << report;
  return kDone;
}

}  // namespace veridyn::cli
