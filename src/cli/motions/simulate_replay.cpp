#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iostream>

#include "veridyn/tool/messages.hpp"
#include "veridyn/tool/option_checks.hpp"
#include "tool/recording_options.hpp"
#include "cli/motions/simulate_request.hpp"
#include "veridyn/recordings/preprocessing.hpp"
#include "math/digits.hpp"
#include "files/output_file.hpp"
#include "veridyn/report/motion_json.hpp"
#include "report/pages/simulation_page.hpp"
#include "veridyn/simulation/engine.hpp"

namespace veridyn::cli {
namespace {

constexpr double kRampCutoff = 20.0;  // [Hz] low-pass of the positions for slow ramps

// The input of a replay from a recording; reports the remarks of its reader.
ReplayInput input_of(const SimulateRequest& request, const Model& arm,
                     const PreprocessingOptions& how) {
  ReplayInput input = replay_input(arm, request.replay, how);
  if (!request.common.quiet) {
    report_facts({input.quality});
    for (const std::string& remark : input.remarks) print_message(request.replay + ": " + remark);
  }
  return input;
}

std::string replay_report(const SimulateRequest& request, const Model& arm, const Replay& r) {
  std::string out = fmt::format("Replayed {} on {} with its {}: {} rows, {:.4g} s.\n",
                                request.replay, arm.name(), request.drive, r.run.motion.rows(),
                                r.run.motion.time[r.run.motion.rows() - 1] - r.run.motion.time[0]);
  for (int i = 0; i < arm.joints(); ++i) {
    const Coordinate& c = arm.coordinates()[i];
    out += fmt::format("joint {} ({}): ", i + 1, c.name);
    if (request.drive != "torques") {
      out += fmt::format(
          "torque off by {} % of the recorded one (the model alone, at the "
          "recorded motion: {} %); ",
          in_percent(r.torque_error[i]), in_percent(r.inverse_error[i]));
    }
    out += fmt::format("motion off by {:.3g} {} rms, {:.3g} at most\n", 1e3 * r.motion_rms[i],
                       c.prismatic ? "mm" : "mrad", 1e3 * r.motion_max[i]);
  }
  return out;
}

// True if the arm under recorded torques has left the recorded motion by more than its joint's
// range, after which a comparison is meaningless.
bool has_diverged(const Model& arm, const Replay& r) {
  for (int i = 0; i < arm.joints(); ++i) {
    const Coordinate& c = arm.coordinates()[i];
    const double range = c.limits.upper - c.limits.lower;
    if (!std::isfinite(range) || r.motion_max[i] <= range) continue;
    print_message(fmt::format("the arm is lost: joint {} ends up to {:.3g} {unit} off the recorded motion, "
                    "more than its whole range of {:.3g} {unit}; nothing was written.",
                    c.name, r.motion_max[i], range, fmt::arg("unit", c.prismatic ? "m" : "rad")));
    return true;
  }
  return false;
}

}  // namespace

ExitStatus run_replay(const SimulateRequest& request, const Model& arm,
                      const std::string& command_line) {
  const auto engine = make_engine(request.engine, arm);
  ReplayOptions options;
  options.drive = request.drive == "torques"      ? ReplayDrive::kTorques
                  : request.drive == "set-points" ? ReplayDrive::kSetPoints
                                                  : ReplayDrive::kCommands;
  options.set_point_cutoff = request.set_point_cutoff;
  options.loop = control_loop_options(request, arm);
  options.cutoff = request.preprocessing.cutoff;
  options.order = request.preprocessing.order;
  const ReplayInput input = input_of(request, arm, request.preprocessing);
  if (std::find(input.use.begin(), input.use.end(), 1) == input.use.end()) {
    print_message(request.replay + ": no usable samples are left after gaps, edges and row limits");
    return kDataCannotAnswer;
  }
  const Replay done = while_busy(request.common, "replaying",
                                 [&] { return replay(*engine, arm, input, options); });
  report_omitted_effects(request, engine->left_out());
  if (stopped(done.run, arm)) return kDataCannotAnswer;
  if (request.drive == "torques" && has_diverged(arm, done)) return kDataCannotAnswer;
  if (!request.output.empty())
    write_recording(rows_of(done.run.motion, done.run.tau), request.output);
  if (!request.common.json.empty()) write_file(request.common.json, to_json(done, arm));
  const std::string report = replay_report(request, arm, done);
  if (!request.common.report.empty())
    write_file(request.common.report,
               to_page(done, arm, input, {request.replay, command_line, report}));
  std::cout << report;
  return kDone;
}

ExitStatus run_breakaway(const SimulateRequest& request, const Model& arm,
                         const std::string& command_line) {
  BreakawayOptions options;
  std::optional<JointIndex> joint = arm.find_coordinate(request.breakaway);
  for (int i = 0; i < arm.joints(); ++i) {
    if (request.breakaway == std::to_string(i + 1)) joint = {i};
  }
  expect_value(joint.has_value(), "--breakaway", "found the joint '", request.breakaway,
               "', expected a coordinate of ", arm.name(), " or its number");
  options.joint = *joint;
  const Coordinate& c = arm.coordinates()[options.joint.value];
  options.speed = request.breakaway_speed;
  const auto engine = make_engine(request.engine, arm);
  PreprocessingOptions how = request.preprocessing;
  // A high cut-off preserves jumps of the position, which mark a new start.
  how.signal_cutoff_ratio = kRampCutoff / how.cutoff;
  const ReplayInput input = input_of(request, arm, how);
  const Breakaway found = breakaway(*engine, arm, input, options);
  report_omitted_effects(request, engine->left_out());
  if (!request.common.json.empty()) write_file(request.common.json, to_json(found, arm));
  if (!request.output.empty()) {
    MotionSamples motion = input.motion;
    motion.q.col(options.joint.value) = found.simulated_q;
    write_recording(rows_of(motion, input.tau), request.output);
  }
  const std::string report = found.report(c, request.replay);
  if (!request.common.report.empty())
    write_file(request.common.report,
               to_page(found, arm, input, {request.replay, command_line, report}));
  std::cout << report;
  return found.events.empty() ? kDataCannotAnswer : kDone;
}

}  // namespace veridyn::cli
