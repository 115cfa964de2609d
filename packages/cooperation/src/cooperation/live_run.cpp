#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <thread>
#include <vector>

#include "experiment.hpp"
#include "motion_plan.hpp"
#include "waiting_lines.hpp"
#include "cooperation/scenario/scenario_models.hpp"
#include "veridyn/cooperation/live.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

using Clock = std::chrono::steady_clock;
using Eigen::Vector3d;

constexpr double kJogAhead = 0.1;    // [s] planned in advance by a jog
constexpr double kStopped = 0.5;     // [s] after the loss of the connection, when all motion must have ended

// Plan with the models of the controllers and the torque limits of the robot files.
MotionPlan make_motion_plan(const Scenario& scenario) {
  std::vector<PlannedArm> arms;
  for (std::size_t k = 0; k < scenario.arms.size(); ++k) {
    const ScenarioModels models = scenario_models(scenario, k);
    VectorXd torque(models.known.joints());
    for (int i = 0; i < models.known.joints(); ++i)
      torque[i] = models.known.coordinates()[i].limits.effort;
    arms.push_back({models.known, models.R_world_base_known, models.p_world_base_known, torque});
  }
  return {scenario, std::move(arms)};
}

class LiveLoop {
 public:
  LiveLoop(const Scenario& scenario, LineSource& lines, const LiveOptions& options,
       const LiveReport& tell)
      : scenario_(scenario),
        lines_(lines),
        options_(options),
        callbacks_(tell),
        experiment_(scenario, options.engine),
        plan_(make_motion_plan(scenario)),
        period_(1.0 / scenario.control.rate) {}

  LiveRun run() {
    const Clock::time_point begun = Clock::now();
    double end = options_.longest;
    for (out_.time = 0.0; out_.time < end && !quits_; out_.time += period_) {
      read_lines();
      check_line_and_state();
      if (jogs_) jog();
      const bool sound = experiment_.step();
      if (line_at_ != Clock::time_point()) {
        const double late = std::chrono::duration<double>(Clock::now() - line_at_).count();
        out_.longest_latency = std::max(out_.longest_latency, late);
        line_at_ = {};
      }
      update_extremes();
      if (!sound) {
        out_.status = experiment_.status();
        break;
      }
      if (out_.lost) end = std::min(end, out_.lost_at + options_.hold + kStopped);
      if (options_.pace > 0.0)
        std::this_thread::sleep_until(
            begun + std::chrono::duration_cast<Clock::duration>(
                        std::chrono::duration<double>((out_.time + period_) / options_.pace)));
    }
    out_.state = experiment_.controller().state();
    report_state();
    return out_;
  }

 private:
  void read_lines() {
    if (quits_ || out_.lost) return;
    if (const std::optional<int> dropped = lines_.stopped(out_.time)) stop(*dropped);
    std::string line;
    while (out_.time >= waits_until_ && !quits_ && !out_.lost && lines_.next(line)) {
      line_at_ = Clock::now();
      heard_ = out_.time;
      began_ = true;
      try {
        const LiveCommand command = parse_live_command(line, scenario_);
        const std::string why = refusal_reason(command);
        if (const std::optional<int> dropped = lines_.stopped(out_.time)) {  // during the planning of this line
          stop(*dropped + 1);
          continue;
        }
        if (!why.empty()) throw InvalidInput(text("'", line, "': ", why, "."));
        execute(command);
      } catch (const InvalidInput& error) {
        ++out_.refused;
        if (callbacks_.refused) callbacks_.refused(error.what());
      }
    }
  }

  void stop(int dropped) {
    line_at_ = Clock::now();
    heard_ = waits_until_ = out_.time;
    began_ = true;
    execute(LiveStop{});
    out_.refused += dropped;
    if (dropped > 0 && callbacks_.refused) callbacks_.refused(dropped_lines_message(dropped));
  }

  // Reason for which a command cannot be executed, empty if it can. A refused command is not begun, as on
  // boards.
  std::string refusal_reason(const LiveCommand& command) {
    if (experiment_.controller().state() != CooperativeState::kTracking) return "";
    const auto* jog = std::get_if<LiveJog>(&command);
    const auto* one = std::get_if<ScenarioCommand>(&command);
    if (jog == nullptr && one == nullptr) return "";
    std::vector<VectorXd> q;
    for (int k = 0; k < experiment_.arms(); ++k) q.push_back(experiment_.world().q(k));
    MotionPlan::State state = plan_.state_during_run(experiment_.controller(), experiment_.measured_input(), q);
    return jog != nullptr ? plan_.jog(std::move(state), jog->velocity, options_.silence)
                          : plan_.check_command(std::move(state), *one);
  }

  void execute(const LiveCommand& command) {
    if (std::holds_alternative<LiveAlive>(command)) return;
    ++out_.commands;
    if (std::holds_alternative<LiveQuit>(command)) quits_ = true;
    if (const auto* wait = std::get_if<LiveWait>(&command)) {
      waits_until_ = out_.time + wait->seconds;
      heard_ = waits_until_;
    }
    if (const auto* jog = std::get_if<LiveJog>(&command)) {
      velocity_ = jog->velocity;
      jogs_ = true;
      return;
    }
    if (std::holds_alternative<LiveWait>(command)) return;
    jogs_ = false;
    if (std::holds_alternative<LiveStop>(command)) experiment_.stop();
    const auto* one = std::get_if<ScenarioCommand>(&command);
    if (one == nullptr || experiment_.execute(*one)) return;
    ++out_.refused;
    if (callbacks_.refused)
      callbacks_.refused(text("the controller ", describe(experiment_.controller().state()),
                         " or is still turning: the command was not taken."));
  }

  // Short moves, one after the other, so that the velocity is kept.
  void jog() {
    if (out_.time < next_jog_) return;
    next_jog_ = out_.time + 0.5 * kJogAhead;
    if (const std::string why = refusal_reason(LiveJog{velocity_}); !why.empty()) {
      jogs_ = false;
      experiment_.stop();
      if (callbacks_.refused) callbacks_.refused(text("the jog ends: ", why, "."));
      return;
    }
    ScenarioCommand move;
    move.way = velocity_ * 0.5 * kJogAhead;
    move.over = kJogAhead;
    experiment_.execute(move);
  }

  void check_line_and_state() {
    if (out_.lost || quits_) return;
    const bool silent = options_.watches_silence && began_ && out_.time - heard_ > options_.silence;
    const bool ended = lines_.closed() && out_.time >= waits_until_;
    if (jogs_ && out_.time - heard_ > options_.silence) {  // a jog needs regular signs of life
      jogs_ = false;
      experiment_.stop();
    }
    if (!silent && !ended) return;
    out_.lost = true;
    out_.lost_at = out_.time;
    jogs_ = false;
    experiment_.stop();
  }

  void update_extremes() {
    for (std::size_t k = 0; k < scenario_.members.size(); ++k)
      out_.largest_force = std::max(
          out_.largest_force, std::abs(experiment_.world().member(static_cast<int>(k)).tension));
    if (out_.lost && out_.time >= out_.lost_at + kStopped) {
      for (int k = 0; k < experiment_.arms(); ++k) {
        const Vector3d tip = experiment_.tip(k);
        if (held_.size() <= static_cast<std::size_t>(k)) held_.push_back(tip);
        out_.moved_after_loss = std::max(out_.moved_after_loss,
                                         (tip - held_[k]).norm());
      }
    }
    if (out_.time >= told_) {
      told_ = out_.time + options_.tell;
      report_state();
    }
  }

  void report_arms() {
    if (!callbacks_.arms) return;
    std::vector<LiveArm> arms;
    for (int k = 0; k < experiment_.arms(); ++k)
      arms.push_back({experiment_.world().q(k), experiment_.world().dq(k), experiment_.tau(k)});
    callbacks_.arms(out_.time, arms);
  }

  void report_state() {
    report_arms();
    if (!callbacks_.state) return;
    std::string line = fmt::format("t={:.3f} state=\"{}\"", out_.time,
                                   describe(experiment_.controller().state()));
    for (int k = 0; k < experiment_.arms(); ++k) {
      const Vector3d tip = experiment_.tip(k);
      line += fmt::format(" {}={:.5f},{:.5f},{:.5f}", scenario_.arms[k].name,
                          tip.x(), tip.y(), tip.z());
    }
    for (std::size_t k = 0; k < scenario_.members.size(); ++k)
      line += fmt::format(" {}={:.3f}", scenario_.members[k].name,
                          experiment_.world().member(static_cast<int>(k)).tension);
    callbacks_.state(line);
  }

  const Scenario& scenario_;
  WaitingLines lines_;
  LiveOptions options_;
  LiveReport callbacks_;
  Experiment experiment_;
  MotionPlan plan_;
  double period_;
  LiveRun out_;
  bool quits_ = false, jogs_ = false, began_ = false;
  double heard_ = 0.0, waits_until_ = 0.0, next_jog_ = 0.0, told_ = 0.0;
  Vector3d velocity_{Vector3d::Zero()};
  Clock::time_point line_at_;
  std::vector<Vector3d> held_;
};

}  // namespace

LiveRun run_live(const Scenario& scenario, LineSource& lines, const LiveOptions& options,
                 const LiveReport& tell) {
  require(options.pace >= 0.0 && options.silence > 0.0 && options.hold >= 0.0 &&
              options.longest > 0.0 && options.tell > 0.0,
          "live run: found a time or a pace below zero.");
  return LiveLoop(scenario, lines, options, tell).run();
}

std::string LiveRun::report() const {
  std::string out = fmt::format("{:.4g} s, {} commands, {} refused; largest force {:.3g} N.\n", time,
                                commands, refused, largest_force);
  if (lost)
    out += fmt::format("At {:.4g} s the line was lost: all was held, within {:.3g} mm.\n", lost_at,
                       1e3 * moved_after_loss);
  if (state != CooperativeState::kTracking) out += fmt::format("The controller {}.\n", describe(state));
  if (status != StepStatus::kOk) out += fmt::format("Stopped: an arm {}.\n", describe(status));
  return out;
}

}  // namespace veridyn
