#include <fmt/format.h>

#include <cmath>
#include <iostream>
#include <set>

#include "cli/options/messages.hpp"
#include "cli/options/option_checks.hpp"
#include "cli/options/recording_options.hpp"
#include "cli/motions/simulate_request.hpp"
#include "veridyn/recordings/preprocessing.hpp"
#include "veridyn/recordings/recording_quality.hpp"
#include "recordings/remark.hpp"
#include "math/output_file.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/report/motion_json.hpp"
#include "report/pages/simulation_page.hpp"
#include "veridyn/simulation/engine.hpp"

namespace veridyn::cli {
namespace {

constexpr double kRampCutoff = 20.0;  // [Hz] for positions of slow ramps

// Joints (from 0) whose recorded velocity is worse than the derivative of their position.
std::vector<int> faulty_velocities(const SimulateRequest& request,
                                   const RecordingOptions& reading) {
  std::set<int> joints;
  const RecordingQuality quality = check_recording(request.replay, reading);
  if (!request.common.quiet) tell_facts({quality});
  for (const QualityFinding& f : quality.findings) {
    const bool velocity = f.finding == "velocity_scale" || f.finding == "velocity_quantised" ||
                          f.finding == "velocity_delay";
    if (!velocity || f.severity == Severity::kInfo || f.joint < 1) continue;
    if (joints.insert(f.joint - 1).second && !request.common.quiet)
      say(request.replay + ": " + f.sentence + " The replay takes it from the position.");
  }
  return {joints.begin(), joints.end()};
}

// The recording on its uniform grid, lightly low-passed, as identification sees it.
ReplayInput replay_input(const SimulateRequest& request, const Model& arm,
                         PreprocessingOptions how) {
  how.derive_velocity_of = faulty_velocities(request, reading_of(arm, how));
  std::vector<double> time;
  std::vector<char> use;
  std::vector<MatrixXd> pieces[4];
  const auto collect = [&](const Stretch& s) {
    const Eigen::Index first = s.core_begin;
    const Eigen::Index count = s.core_end - s.core_begin;
    for (Eigen::Index k = first; k < first + count; ++k) {
      time.push_back(s.time[k]);
      use.push_back(s.use[static_cast<size_t>(k)]);
    }
    const MatrixXd* all[] = {&s.q, &s.dq, &s.ddq, &s.tau};
    for (size_t m = 0; m < 4; ++m) pieces[m].emplace_back(all[m]->middleRows(first, count));
  };
  const PreparationFacts facts = for_each_stretch(arm, request.replay, how, collect);
  if (facts.filled.count > 0 && !request.common.quiet)
    say(request.replay + ": " + filled_text(facts.filled, facts.rows_read) + ".");
  MatrixXd whole[4];
  for (size_t m = 0; m < 4; ++m) {
    whole[m].resize(static_cast<Eigen::Index>(time.size()), arm.joints());
    Eigen::Index row = 0;
    for (const MatrixXd& piece : pieces[m]) {
      whole[m].middleRows(row, piece.rows()) = piece;
      row += piece.rows();
    }
  }
  const auto rows = static_cast<Eigen::Index>(time.size());
  return {
      {Eigen::Map<const VectorXd>(time.data(), rows), whole[0], whole[1], whole[2]}, whole[3], use};
}

std::string replay_report(const SimulateRequest& request, const Model& arm, const Replay& r) {
  std::string out = fmt::format("Replayed {} on {} with its {}: {} rows, {:.4g} s.\n",
                                request.replay, arm.name(), request.drive, r.run.motion.rows(),
                                r.run.motion.time[r.run.motion.rows() - 1] - r.run.motion.time[0]);
  for (int i = 0; i < arm.joints(); ++i) {
    const Coordinate& c = arm.coordinates()[static_cast<size_t>(i)];
    out += fmt::format("joint {} ({}): ", i + 1, c.name);
    if (request.drive != "torques") {
      out += fmt::format(
          "torque off by {:.2f} % of the recorded one (the model alone, at the "
          "recorded motion: {:.2f} %); ",
          100.0 * r.torque_error[i], 100.0 * r.inverse_error[i]);
    }
    out += fmt::format("motion off by {:.3g} {} rms, {:.3g} at most\n", 1e3 * r.motion_rms[i],
                       c.prismatic ? "mm" : "mrad", 1e3 * r.motion_max[i]);
  }
  return out;
}

// An arm that torques alone have taken farther from the recorded motion than its joint can move has
// nothing to do with that motion any more.
bool lost(const Model& arm, const Replay& r) {
  for (int i = 0; i < arm.joints(); ++i) {
    const Coordinate& c = arm.coordinates()[static_cast<size_t>(i)];
    const double range = c.limits.upper - c.limits.lower;
    if (!std::isfinite(range) || r.motion_max[i] <= range) continue;
    say(fmt::format("the arm is lost: joint {} ends up to {:.3g} {unit} off the recorded motion, "
                    "more than its whole range of {:.3g} {unit}; nothing was written.",
                    c.name, r.motion_max[i], range, fmt::arg("unit", c.prismatic ? "m" : "rad")));
    return true;
  }
  return false;
}

std::string breakaway_report(const SimulateRequest& request, const Coordinate& c,
                             const Breakaway& found) {
  std::string out = fmt::format("Breakaway of {} in {}: {} ramps.\n", c.name, request.replay,
                                found.events.size());
  const auto level = [&c](double effort) {
    return std::isfinite(effort) ? fmt::format("{:+.3f} {}", effort, effort_unit(c)) : std::string("none");
  };
  size_t held[2] = {0, 0};  // forwards, backwards: ramps at which the simulated joint stays at rest
  size_t ramps[2] = {0, 0};
  for (const BreakawayEvent& e : found.events) {
    const size_t back = e.direction > 0 ? 0 : 1;
    const bool gave_way = std::isfinite(e.simulated);
    ++ramps[back];
    held[back] += gave_way ? 0 : 1;
    out += fmt::format("  at rest from {:.2f} s: recorded {} at {:.2f} s, simulated {}\n", e.rest_from,
                       level(e.recorded), e.recorded_at,
                       gave_way ? fmt::format("{} at {:.2f} s", level(e.simulated), e.simulated_at)
                                : std::string("did not give way"));
  }
  if (found.events.empty()) return out;
  const auto median = [&](const char* way, double recorded, double simulated, size_t back) {
    std::string line = fmt::format("median {} recorded {}, simulated {}", way, level(recorded), level(simulated));
    if (held[back] > 0)
      line += fmt::format(" (without {} of {} ramps, at which it did not give way)", held[back], ramps[back]);
    return line + "\n";
  };
  out += median("forwards: ", found.recorded_forward, found.simulated_forward, 0);
  out += median("backwards:", found.recorded_backward, found.simulated_backward, 1);
  return out;
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
  options.loop = loop_of(request, arm);
  options.cutoff = request.preprocessing.cutoff;
  options.order = request.preprocessing.order;
  const ReplayInput input = replay_input(request, arm, request.preprocessing);
  const Replay done = replay(*engine, arm, input, options);
  tell_left_out(request, engine->left_out());
  if (stopped(done.run, arm)) return kDataCannotAnswer;
  if (request.drive == "torques" && lost(arm, done)) return kDataCannotAnswer;
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
  options.joint = arm.find_coordinate(request.breakaway);
  for (int i = 0; i < arm.joints(); ++i) {
    if (request.breakaway == std::to_string(i + 1)) options.joint = i;
  }
  expect_value(options.joint >= 0, "--breakaway", "found the joint '", request.breakaway,
               "', expected a coordinate of ", arm.name(), " or its number");
  const Coordinate& c = arm.coordinates()[static_cast<size_t>(options.joint)];
  options.speed = request.breakaway_speed;
  const auto engine = make_engine(request.engine, arm);
  PreprocessingOptions how = request.preprocessing;
  how.signal_cutoff_ratio = kRampCutoff / how.cutoff;  // a step of position is a new start
  const ReplayInput input = replay_input(request, arm, how);
  const Breakaway found = breakaway(*engine, arm, input, options);
  tell_left_out(request, engine->left_out());
  if (!request.common.json.empty()) write_file(request.common.json, to_json(found, arm));
  if (!request.output.empty()) {
    MotionSamples motion = input.motion;
    motion.q.col(options.joint) = found.simulated_q;
    write_recording(rows_of(motion, input.tau), request.output);
  }
  const std::string report = breakaway_report(request, c, found);
  if (!request.common.report.empty())
    write_file(request.common.report,
               to_page(found, arm, input, {request.replay, command_line, report}));
  std::cout << report;
  return found.events.empty() ? kDataCannotAnswer : kDone;
}

}  // namespace veridyn::cli
