#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <memory>

#include "cli/boards/dvrk_request.hpp"
#include "veridyn/tool/messages.hpp"
#include "veridyn/tool/option_checks.hpp"
#include "dvrk/arms/arm_facts.hpp"
#include "dvrk/run/controllers/model_controller.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "veridyn/simulation/simulate_recording.hpp"

namespace veridyn::cli {
namespace {

using dvrk::ArmSession;

// PID gains of the known arm; with a model, gains computed from it replace those of the model's joints.
PidGains pid_gains(const DvrkRequest& request, const DvrkArm& arm) {
  const int n = arm.robot.size();
  PidGains gains{VectorXd::Zero(n), VectorXd::Zero(n), VectorXd::Zero(n)};
  const std::vector<std::string> known = dvrk::arm_names();
  const std::string name = request.arm.empty() ? arm.robot.name : request.arm;
  const bool is_known = std::find(known.begin(), known.end(), name) != known.end();
  require(is_known || !request.model.empty(), "gains: '", name,
          "' is no known arm; --model names a robot that they shall fit.");
  if (is_known) {
    const dvrk::ArmFacts facts = dvrk::read_arm(name);
    for (int j = 0; j < n; ++j) {
      gains.p[j] = facts.actuators[j].kp;
      gains.d[j] = facts.actuators[j].kd;
    }
  }
  if (request.model.empty()) return gains;
  const Model model = read_model(request.model);
  require(model.joints() <= n, model.name(), " has ", model.joints(),
          " joints, expected at most the ", n, " actuators of the arm (--model).");
  const PidGains fit = request.gains.empty() || request.controller != "pid"
                           ? sensible_gains(model)
                           : read_gains(request.gains, model);
  gains.p.head(model.joints()) = fit.p;
  gains.i.head(model.joints()) = fit.i;
  gains.d.head(model.joints()) = fit.d;
  return gains;
}

// Motion of a file with missing derivatives computed; throws InvalidInput that names the file.
MotionSamples read_motion(const std::string& path) {
  RecordingOptions reading;
  reading.signals.as_recorded = true;  // the rows of a wanted motion are not repaired
  const Recording rows = read_recording(path, reading);
  try {
    return with_derivatives({rows.time, rows.q, rows.dq, rows.ddq});
  } catch (const InvalidInput& error) {
    throw InvalidInput(text(path, ": ", error.what()));
  }
}

// Throws a usage error if an option is missing, or given for a controller that does not use it.
void require_inputs(const DvrkRequest& request) {
  const std::string& name = request.controller;
  const bool pid = name == "pid";
  const bool plays = name != "gravity";
  expect_prerequisites(*request.command, {{"--gains", name != "gravity" && !request.model.empty(),
                                           "--model and another controller than gravity"},
                                          {"--tip", name == "impedance", "--controller impedance"},
                                          {"--stiffness", name == "impedance", "--controller impedance"},
                                          {"--seconds", !plays, "--controller gravity"},
                                          {"--trajectory", plays, "another controller than gravity"},
                                          {"--approach-speed", plays, "another controller than gravity"},
                                          {"--largest-error", plays, "another controller than gravity"},
                                          {"--event", request.emulate, "--emulate"}});
  expect_value(request.gains.empty() || request.command->count("--stiffness") == 0, "--stiffness",
               "found --gains beside it, expected one of them");
  expect_value(!plays || !request.trajectory.empty(), "--trajectory",
               "expected a motion for --controller ", name);
  expect_value(pid || !request.model.empty(), "--model", "--controller ", name,
               " needs a model with values");
}

// Controller of the request; null for PID.
std::unique_ptr<dvrk::ModelController> make_controller(const DvrkRequest& request,
                                                     const PidGains& gains, const ArmSession& arm) {
  if (request.controller == "pid") return nullptr;
  dvrk::ModelControlOptions options;
  options.law = request.controller == "gravity"     ? dvrk::ControlLaw::kGravity
                : request.controller == "impedance" ? dvrk::ControlLaw::kImpedance
                                                    : dvrk::ControlLaw::kComputedTorque;
  options.tip = request.tip;
  options.stiffness = request.stiffness;
  options.position_steps = arm.units().joint_steps();
  options.longest_gap = request.watchdog;  // after a longer gap the boards switch off
  const Model model = read_model(request.model);
  if (!request.gains.empty() && options.law == dvrk::ControlLaw::kComputedTorque)
    options.joint_gains = read_joint_gains(request.gains, model);
  if (!request.gains.empty() && options.law == dvrk::ControlLaw::kImpedance)
    options.tip_gains = read_tip_gains(request.gains);
  if (!request.tip.empty()) expect_one_of("--tip", request.tip, frame_names(model));
  auto controller =
      std::make_unique<dvrk::ModelController>(model, gains, dvrk::largest_torques(arm), options);
  for (const std::string& effect : controller->left_out())
    print_message("the controller leaves out " + effect);
  return controller;
}

// (n) [rad], [m] largest position errors; a single number of the request applies to the revolute joints.
VectorXd largest_errors(const DvrkRequest& request, const dvrk::RobotConfig& robot) {
  VectorXd all = dvrk::default_largest_errors(robot);
  const std::vector<double>& given = request.largest_error;
  if (given.empty()) return all;
  if (static_cast<int>(given.size()) == robot.size())
    return Eigen::Map<const VectorXd>(given.data(), robot.size());
  expect_value(given.size() == 1, "--largest-error", "found ", given.size(),
               " numbers, expected one, or ", robot.size(), ", one per joint of ", robot.name);
  for (int i = 0; i < robot.size(); ++i) {
    if (!robot.actuators[i].prismatic) all[i] = given.front();
  }
  return all;
}

dvrk::RunOptions run_options(const DvrkRequest& request, const dvrk::RobotConfig& robot) {
  dvrk::RunOptions options;
  options.rate = request.rate;
  options.approach_speed = request.approach_speed;
  options.largest_error = largest_errors(request, robot);
  options.recording = request.output;
  return options;
}

}  // namespace

ExitStatus run_dvrk_run(const DvrkRequest& request) {
  require_inputs(request);
  require_writable(request.output, request.common.json);
  const DvrkArm arm = read_dvrk_arm(request);
  const bool in_place = request.controller == "gravity";
  const MotionSamples motion = in_place ? MotionSamples() : read_motion(request.trajectory);
  const PidGains gains = pid_gains(request, arm);
  const dvrk::RunOptions options = run_options(request, arm.robot);
  const std::unique_ptr<dvrk::DatagramLink> boards = link_to_boards(request);
  dvrk::DatagramLink& link = *boards;
  ArmSession session(link, arm.robot, session_options(request, arm));
  const auto controller = make_controller(request, gains, session);
  catch_signals();
  const std::vector<std::string> refused =
      request.emulate ? std::vector<std::string>() : prepare_loop();
  const dvrk::RunResult done =
      in_place     ? dvrk::run_in_place(session, link, request.seconds, controller->joints(),
                                        *controller, options, stop_requested())
      : controller ? dvrk::run_motion(session, link, motion, *controller, options, stop_requested())
                   : dvrk::run_motion(session, link, motion, gains, options, stop_requested());
  std::cout << fmt::format("{}: {} rows of {}.\n", arm.robot.name, done.rows.rows(),
                           in_place ? "a weightless arm" : request.trajectory);
  const bool off = done.power == dvrk::OffState::kConfirmed;
  const std::string power = off ? "power is off" : unconfirmed_power_text(done.power);
  if (!done.why.empty()) print_message("the run ended: " + done.why + "; " + power + ".");
  if (done.why.empty() && !off) print_message(power + ".");
  for (const std::string& line : refused) print_message(line);  // after the reason for the end of the run
  if (!done.remark.empty()) print_message(request.output + ": " + done.remark + ".");
  finish_dvrk(request, "run", done, session);
  report_rows(request, done);
  return done.complete ? kDone : kDataCannotAnswer;
}

}  // namespace veridyn::cli
