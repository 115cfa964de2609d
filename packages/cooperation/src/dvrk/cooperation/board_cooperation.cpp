#include "dvrk/cooperation/board_cooperation.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <sstream>
#include <thread>

#include "board_loop.hpp"
#include "scenario_row_file.hpp"
#include "cooperation/empty_run.hpp"
#include "cooperation/loop_gains.hpp"
#include "cooperation/motion_plan.hpp"
#include "cooperation/phase_commands.hpp"
#include "cooperation/phase_figures.hpp"
#include "live_hand.hpp"
#include "veridyn/control/load_cell.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

using Eigen::Vector3d;

constexpr double kSettled = 0.2;     // [s] duration of the rest after the last phase
constexpr double kLeastForce = 0.3;  // [N] pretension below which power may be switched off
constexpr double kStands = 1e-3;     // [m/s] speed of a target that rests
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();  // for quantities that are not measured on boards

class BoardRun : private BoardLoop {
 public:
  BoardRun(const Scenario& scenario, const std::vector<CooperatingArm>& arms,
           const BoardCooperationOptions& options, const std::atomic<bool>& stop)
      : BoardLoop(scenario, arms, options, stop) {
    for (size_t k = 0; k < scenario_.walls.size(); ++k) {
      for (int c = 0; c < scenario_.walls[k].sensor_axes; ++c)
        wall_channels_.push_back({static_cast<int>(k), c});
    }
    const size_t sensors = scenario_.members.size() + wall_channels_.size();
    require(options_.force_sources.empty() || options_.force_sources.size() == sensors,
            "boards: found ", options_.force_sources.size(), " force sources, expected ", sensors,
            ", one for each member and wall, and three (x, y, z) for a sensor of three axes.");
    require(options_.emulate || !options_.force_sources.empty() || sensors == 0,
            "boards: found no force source, expected one for each member and wall.");
    open_sensors();
  }

  BoardCooperationRun run() {
    const auto begun = std::chrono::steady_clock::now();
    read_before_power();
    plan();
    read_before_power();
    wait_for_sensors(channels_);
    if (stopped()) fail("stopped by a signal", {}, BoardEnd::kStopped);
    if (why_ == nullptr && power_up(channels_)) {
      begin();
      options_.lines != nullptr ? run_by_lines() : play();
      release_pretension();
    }
    file_.reset();
    out_.off_at = time_;
    out_.force_at_off = largest_measured_force();
    out_.power = power_down();
    if (joined_) out_.largest_force = std::max(out_.largest_force, joined_->largest_force());
    finish();
    out_.run.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    return std::move(out_);
  }

 private:
  void open_sensors() {
    const size_t members = scenario_.members.size();
    for (size_t k = 0; k < members + wall_channels_.size(); ++k) {
      if (options_.force_sources.empty()) {
        simulated_.emplace_back(k < members ? sensor_options(scenario_, static_cast<int>(k))
                                            : wall_sensor_options(scenario_, wall_channel(k).wall,
                                                                  wall_channel(k).channel),
                                0.1);
        continue;
      }
      ForceChannelOptions channel;
      if (k < options_.force_calibrations.size() && !options_.force_calibrations[k].empty())
        channel.calibration = read_load_cell(options_.force_calibrations[k]);
      channel.cutoff = scenario_.control.force_cutoff;
      const std::string of = k < members ? "member '" + scenario_.members[k].name + "'"
                                         : "wall " + std::to_string(wall_channel(k).wall + 1);
      const double rate = k < members ? scenario_.members[k].sensor.rate
                                      : scenario_.walls[wall_channel(k).wall].sensor.rate;
      channels_.push_back(open_sensor(options_.force_sources[k], of, rate, channel));
    }
    readings_.resize(members + wall_channels_.size());
    wall_channel_values_.assign(scenario_.walls.size(), Vector3d::Zero());
    exerted_.assign(sides_.size(), Vector3d::Zero());
    ages_.assign(sides_.size(), 0.0);
  }

  // Plans the phases from the present positions of the arms; if a phase cannot be executed, the run ends
  // before power-up.
  void plan() {
    if (!options_.planned) return;
    plan_ = std::make_unique<MotionPlan>(scenario_, planned_arms());
    if (options_.lines != nullptr) return;
    MotionPlan::State state = plan_->initial_state(initial_state());
    for (std::size_t p = 0; p < scenario_.phases.size(); ++p) {
      const ScenarioPhase& phase = scenario_.phases[p];
      require_feasible(p, state.time, plan_->play(state, phase.commands, phase.duration));
    }
  }

  void begin() {
    std::vector<Vector3d> tips;
    std::vector<Eigen::Matrix3d> bases;
    for (size_t k = 0; k < sides_.size(); ++k) {
      sides_[k]->begin(scenario_, k);
      tips.push_back(sides_[k]->loop().position());
      bases.push_back(sides_[k]->models().R_world_base_known);
    }
    for (auto& side : sides_) side->compare_forces();
    CooperativeOptions task = cooperative_options(scenario_, bases);
    task.drift_length = options_.checks.drift_length;
    task.drift_way = options_.checks.drift_way;
    task.drift_factor = options_.checks.drift_factor;
    control_ = std::make_unique<CooperativeController>(task, tips);
    input_ = std::make_unique<CooperativeInput>(static_cast<int>(tips.size()),
                                                static_cast<int>(scenario_.members.size()));
    bound_ = scenario_.control.relief_force;
    Eigen::Index rows = 0;
    for (const ScenarioPhase& phase : scenario_.phases)
      rows += options_.lines != nullptr ? 0 : rows_of(phase);
    out_.run = empty_run(scenario_, "boards", rows);
    spans_.reserve(scenario_.phases.size());
    for (MemberTrace& trace : out_.run.member) trace.rate.setConstant(kUnknown);
    if (!options_.rows.empty() && rows > 0)
      file_ = std::make_unique<ScenarioRowFile>(options_.rows, out_.run);
  }

  Eigen::Index rows_of(const ScenarioPhase& phase) const {
    return static_cast<Eigen::Index>(std::lround(phase.duration * scenario_.control.rate));
  }

  // Reads all sensors; sets the force of each tip on the object, in the world, and the age of its oldest reading [s].
  void read_forces() noexcept {
    for (Vector3d& f : exerted_) f.setZero();
    std::fill(ages_.begin(), ages_.end(), 0.0);
    for (size_t k = 0; k < readings_.size(); ++k) {
      if (channels_.empty()) {
        const ForceSample sample = simulated_[k].read(time_, true_force(k));
        readings_[k] = {sample.force, time_ - sample.time, sample.number, sample.force};
      } else {
        readings_[k] = read_sensor(channels_[k]);
      }
      if (k >= scenario_.members.size()) {
        const WallChannel of = wall_channel(k);
        const int arm = scenario_.walls[of.wall].arm;
        wall_channel_values_[of.wall][of.channel] = readings_[k].force;
        ages_[arm] = std::max(ages_[arm], readings_[k].age);
        continue;
      }
      input_->force[k] = readings_[k];
      const ScenarioMember& m = scenario_.members[k];
      const auto from = static_cast<size_t>(m.from);
      const auto to = static_cast<size_t>(m.to);
      const Vector3d line = input_->position[to] - input_->position[from];
      const Vector3d u = line.norm() > 0.0 ? Vector3d(line.normalized()) : Vector3d::Zero();
      exerted_[from] -= readings_[k].force * u;
      exerted_[to] += readings_[k].force * u;
      ages_[from] = std::max(ages_[from], readings_[k].age);
      ages_[to] = std::max(ages_[to], readings_[k].age);
    }
    for (size_t w = 0; w < wall_channel_values_.size(); ++w)
      exerted_[scenario_.walls[w].arm] -= wall_force(w, wall_channel_values_[w]);
  }

  struct WallChannel {
    int wall, channel;
  };
  // Readings of walls follow those of members.
  WallChannel wall_channel(size_t reading) const noexcept {
    return wall_channels_[reading - scenario_.members.size()];
  }

  // Force on the tip, in the world, from a wall's channels.
  Vector3d wall_force(size_t wall, const Vector3d& channels) const noexcept {
    const ScenarioWall& w = scenario_.walls[wall];
    return force_of_channels(w, channels, sides_[w.arm]->loop().rotation());
  }

  // [N] of a member or of a wall's channel in the emulated world, by index of the reading.
  double true_force(size_t k) const noexcept {
    if (k < scenario_.members.size()) return joined_->tension(static_cast<int>(k));
    return joined_->true_wall_force(wall_channel(k).wall, wall_channel(k).channel);
  }

  // Tells the controller which arms are faulty, and which are no longer located.
  void watch_arms() noexcept {
    for (size_t k = 0; k < sides_.size(); ++k) {
      if (collect_faults(k)) input_->healthy[k] = 0;
      input_->located[k] = sides_[k]->is_unresponsive() ? 0 : 1;
    }
  }

  // One cycle of the task, which continues while targets are held.
  void work() noexcept {
    for (size_t k = 0; k < sides_.size(); ++k) {
      input_->position[k] = sides_[k]->loop().position();
      input_->velocity[k] = sides_[k]->loop().velocity();
    }
    read_forces();
    watch_arms();
    targets_ = &control_->update(*input_);
    const CooperativeState state = control_->state();
    if (state != CooperativeState::kTracking) fail(describe(state), {});
    const bool holds = state != CooperativeState::kTracking || winding_;
    // A sensor or an encoder is wrong, and it is unknown which: supervisors release all arms, since neither
    // positions nor forces can be controlled.
    const bool unknown = state == CooperativeState::kSensorDrifted;
    if (unknown) std::fill(ages_.begin(), ages_.end(), kNever);
    for (size_t k = 0; k < sides_.size(); ++k) {
      BoardSide& side = *sides_[k];
      const bool blind = control_->sensor_failed() && !unknown;
      // If a tip cannot follow, its target comes to rest far from it: the arm holds its position instead.
      if (blind || state == CooperativeState::kTargetMissed) side.loop().freeze();
      if (!blind && holds && scenario_.control.guard) side.loop().hold_within(bound_, exerted_[k]);
      side.set_held(holds && !gives_up_ && !unknown && keeps_target((*targets_)[k]) && !side.loop().yields());
      side.act((*targets_)[k], exerted_[k], ages_[k], dt_);
    }
    watch_hold();
    const double force = largest_measured_force();
    out_.largest_force = std::max(out_.largest_force, force);
    if (why_ != nullptr)
      out_.largest_force_after_fault = std::max(out_.largest_force_after_fault, force);
    activate_fault();
  }

  // True if the target is at rest: it neither decelerates nor follows a falling arm.
  static bool keeps_target(const TipTarget& target) noexcept {
    return target.velocity.norm() < kStands && target.relief.velocity.norm() < kStands;
  }

  // [N] of all sensors; the true force with emulated boards.
  double largest_measured_force() const noexcept {
    double largest = 0.0;
    for (size_t k = 0; k < readings_.size(); ++k)
      largest = std::max(largest, std::abs(joined_ ? true_force(k) : readings_[k].force));
    return largest;
  }

  void record(Eigen::Index k) noexcept {
    ScenarioRun& run = out_.run;
    run.time[k] = time_;
    for (size_t i = 0; i < sides_.size(); ++i) {
      ArmTrace& trace = run.arm[i];
      trace.q.row(k) = sides_[i]->q().transpose();
      trace.dq.row(k) = sides_[i]->dq().transpose();
      trace.tau.row(k) = sides_[i]->tau().transpose();
      trace.tip.row(k) = sides_[i]->loop().position().transpose();
      trace.motion.row(k) = (*targets_)[i].motion.transpose();
      trace.target.row(k) = (*targets_)[i].position.transpose();
    }
    for (size_t w = 0; w < scenario_.walls.size(); ++w) {
      MemberTrace& trace = run.member[scenario_.members.size() + w];
      const Vector3d& n = scenario_.walls[w].normal;
      const Vector3d measured = wall_force(w, wall_channel_values_[w]);
      Vector3d truth = measured;
      if (joined_) {
        for (int c = 0; c < 3; ++c) truth[c] = joined_->true_wall_force(static_cast<int>(w), c);
        truth = wall_force(w, truth);
      }
      trace.force[k] = truth.dot(n);
      trace.measured[k] = measured.dot(n);
      if (trace.axes.rows() > 0) trace.axes.row(k) = measured.transpose();
    }
    for (size_t i = 0; i < scenario_.members.size(); ++i) {
      MemberTrace& trace = run.member[i];
      trace.force[k] = joined_ ? true_force(i) : readings_[i].force;
      trace.measured[k] = readings_[i].force;
      trace.wanted[k] = control_->wanted_force(static_cast<int>(i));
      trace.x_f[k] = control_->correction(static_cast<int>(i));
      trace.tracked[k] = 1.0;
      if (joined_) trace.rate[k] = joined_->rate(static_cast<int>(i));
    }
  }

  void play() {
    for (const ScenarioPhase& phase : scenario_.phases) {
      for (const ScenarioCommand& c : phase.commands) apply_command(c, *control_);
      const Eigen::Index first = row_;
      const Eigen::Index rows = rows_of(phase);
      for (Eigen::Index k = 0; k < rows && why_ == nullptr; ++k) {
        cycle([this] { work(); });
        record(row_++);
        if (file_) file_->count(row_);
        if (stopped()) fail("stopped by a signal", {}, BoardEnd::kStopped);
      }
      if (row_ > first) spans_.push_back({&phase, first, row_});
      if (why_ != nullptr) return;
    }
  }

  // Executes commands from a line until it ends or is lost.
  void run_by_lines() {
    using Clock = std::chrono::steady_clock;
    LiveHand hand(scenario_, *options_.lines, options_.live, options_.live_report,
                  options_.stepped ? LiveHand::Reads::kBetweenCycles : LiveHand::Reads::kBeside,
                  std::move(plan_));
    const auto joints = [this](std::size_t k) -> const VectorXd& { return sides_[k]->q(); };
    const Clock::time_point begun = Clock::now();
    out_.live = true;
    cycle([this] { work(); });
    hand.show(time_, *control_, *input_, joints);
    for (LiveHand::End end = LiveHand::End::kGoesOn; end != LiveHand::End::kQuit;) {
      cycle([this] { work(); });
      hand.show(time_, *control_, *input_, joints);
      if (why_ == nullptr) end = hand.act(time_, *control_);
      if (end == LiveHand::End::kLost)
        fail("the line of commands is lost", {}, BoardEnd::kStopped);
      if (stopped()) fail("stopped by a signal", {}, BoardEnd::kStopped);
      if (why_ != nullptr) break;
      if (options_.stepped && options_.live.pace > 0.0)
        std::this_thread::sleep_until(begun + std::chrono::duration_cast<Clock::duration>(
                                                  std::chrono::duration<double>(time_ / options_.live.pace)));
    }
    out_.commands = hand.commands();
    out_.refused = hand.refused();
  }

  // Holds all arms, then releases the pretension.
  void release_pretension() {
    out_.run.state = control_->state();
    out_.run.held_at = fault_at_;
    control_->stop();
    winding_ = true;
    repeat(why_ == nullptr ? kSettled : options_.hold, [this] { work(); });
    out_.release_at = time_;
    out_.force_at_release = largest_measured_force();
    gives_up_ = true;
    // The wanted force of a healthy controller decreases as well; otherwise it would report a missing force.
    for (int m = 0; m < static_cast<int>(scenario_.members.size()) && why_ == nullptr; ++m)
      control_->set_force(m, std::clamp(control_->wanted_force(m), -kLeastForce, kLeastForce), options_.release);
    const double relief = scenario_.control.relief_force;
    repeat(options_.release, [this, relief] {
      const double share = (time_ - out_.release_at) / options_.release;
      bound_ = std::max(kLeastForce, relief * (1.0 - share));
      control_->set_relief_force(bound_);
      work();
    });
  }

  void finish() {
    out_.why = cause();
    out_.after_fault = after_fault();
    out_.later = later_faults();
    out_.not_off = not_off_;
    out_.end = end_;
    out_.faulty_arm = faulty_arm_;
    out_.fault_at = fault_at_;
    out_.cycles = timing_.cycles;
    out_.late = timing_.late;
    out_.stepped = options_.stepped;
    out_.mean_cycle = timing_.mean_cycle;
    out_.longest_cycle = timing_.longest_cycle;
    if (out_.run.arm.empty()) out_.run = empty_run(scenario_, "boards", 0);  // the arms were never powered
    keep_first_rows(out_.run, row_);
    for (const Span& span : spans_)
      out_.run.phases.push_back(
          phase_figures(scenario_, *span.phase, out_.run, span.first, span.end));
    out_.run.largest_force = out_.largest_force;
    out_.run.asked_largest_force = scenario_.asked_largest_force;
  }

  struct Span {
    const ScenarioPhase* phase;
    Eigen::Index first, end;
  };

  std::vector<ForceSensor> simulated_;
  std::vector<Sensor> channels_;
  std::vector<ForceReading> readings_;  // readings of members, then of the channels of walls
  std::vector<WallChannel> wall_channels_;
  std::vector<Vector3d> wall_channel_values_;  // [N] latest readings of the channels, by wall
  std::unique_ptr<CooperativeController> control_;
  std::unique_ptr<CooperativeInput> input_;
  const std::vector<TipTarget>* targets_ = nullptr;
  std::vector<Vector3d> exerted_;
  std::vector<double> ages_;
  std::vector<Span> spans_;
  BoardCooperationRun out_;
  Eigen::Index row_ = 0;
  double bound_ = 5.0;  // [N] largest force of an arm that holds its position
  bool winding_ = false;
  std::unique_ptr<MotionPlan> plan_;
  std::unique_ptr<ScenarioRowFile> file_;
};

// Simulates the scenario without its faults, and rejects it if a bound is not satisfied.
void check_by_simulation(Scenario scenario) {
  scenario.faults.clear();
  bool asks = scenario.asked_largest_force > 0.0;
  for (const ScenarioPhase& p : scenario.phases)
    asks = asks || p.asked_force_error > 0.0 || p.asked_steady_error > 0.0 || p.asked_position_error > 0.0;
  if (!asks) return;
  const ScenarioRun run = run_scenario(scenario, "veridyn");
  if (run.met()) return;
  std::string why;
  std::istringstream lines(run.report());
  for (std::string line; std::getline(lines, line);)
    if (line.find("NOT met") != std::string::npos || line.find("Stopped at") == 0 || line.find("the controller holds") != std::string::npos)
      why += (why.empty() ? "" : " ") + line;
  throw InvalidInput(text("scenario '", scenario.name, "': simulated, it does not keep what it asks for: ", why,
                          " Nothing was switched on; --unrehearsed leaves the simulation out."));
}

}  // namespace

BoardCooperationRun run_on_boards(const Scenario& scenario, const std::vector<CooperatingArm>& arms,
                                  const BoardCooperationOptions& options,
                                  const std::atomic<bool>& stop) {
  require(scenario.bodies.empty(), "boards: scenario '", scenario.name,
          "': found bodies, expected members between arms and walls alone.");
  if (options.rehearsed && options.lines == nullptr) check_by_simulation(scenario);
  return BoardRun(scenario, arms, options, stop).run();
}

}  // namespace veridyn::dvrk
