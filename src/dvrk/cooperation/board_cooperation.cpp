#include "dvrk/cooperation/board_cooperation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <thread>

#include "cooperation/arm_loop.hpp"
#include "cooperation/empty_run.hpp"
#include "cooperation/loop_gains.hpp"
#include "cooperation/phase_commands.hpp"
#include "cooperation/phase_figures.hpp"
#include "cooperation/scenario_models.hpp"
#include "joined_arms.hpp"
#include "veridyn/control/load_cell.hpp"
#include "dvrk/run/arm_session.hpp"
#include "dvrk/protocol/udp_link.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

using Eigen::Vector3d;

constexpr double kLooking = 0.1;       // [s] of reading before power is asked for
constexpr double kLeastForce = 0.3;    // [N] of pretension that is left before power goes
constexpr double kForceFactor = 1.5;   // multiple of the controller's bound: the supervisor's own
constexpr double kNoTorqueSeconds = 0.5;

// One arm: its boards, its loop, its supervisor.
struct Side {
  Side(const Scenario& scenario, std::size_t index, const CooperatingArm& arm,
       const BoardCooperationOptions& options, std::uint16_t port)
      : models(scenario_models(scenario, index)),
        link(options.emulate ? "127.0.0.1" : arm.host, options.emulate ? port : arm.port),
        session(link, arm.robot, options_of(scenario, arm, options)),
        joints(models.known.joints()),
        q(VectorXd::Zero(joints)),
        rest(q),
        tau(q),
        all(VectorXd::Zero(session.size())),
        state(models.known, {scenario.arms[index].frame, scenario.arms[index].offset}),
        input(joints) {
    require(joints <= session.size(), "arm '", scenario.arms[index].name, "': found a model of ",
            joints, " joints, but boards for ", session.size(), ".");
    session.start();
  }

  static ArmSessionOptions options_of(const Scenario& scenario, const CooperatingArm& arm,
                                           const BoardCooperationOptions& options) {
    ArmSessionOptions o;
    o.actuator_to_joint = arm.coupling;
    o.rate = scenario.control.rate;
    o.watchdog = options.watchdog;
    return o;
  }

  // Begins control where the arm stands.
  void begin(const Scenario& scenario, std::size_t index) {
    ArmLoopSetup setup{models.known,
                       {scenario.arms[index].frame, scenario.arms[index].offset},
                       models.R_world_base_known,
                       models.p_world_base_known,
                       scenario.arms[index].control,
                       scenario.control,
                       VectorXd::Zero(joints),
                       session.state().q.head(joints)};
    loop.emplace(setup);
    VectorXd most(joints);
    for (int i = 0; i < joints; ++i) {
      const ActuatorConfig& a = session.robot().actuators[static_cast<size_t>(i)];
      most[i] = std::abs(a.max_current / a.effort_to_amps);
    }
    SafetyLimits limits = safety_limits(models.known, 1.0);
    limits.torque = most;
    limits.force = kForceFactor * scenario.control.largest_force;
    limits.force_age = 10.0 * scenario.control.largest_age;
    limits.overrun = 0.05;
    limits.sensor_age = 0.02;
    limits.torque_seconds = kNoTorqueSeconds;
    supervisor = std::make_unique<SafetySupervisor>(models.known, limits);
    supervisor->enable();
    supervisor->activate();
    input.q_wanted.setConstant(std::numeric_limits<double>::quiet_NaN());
    input.force_expected.setConstant(std::numeric_limits<double>::quiet_NaN());
  }

  ScenarioModels models;
  UdpLink link;
  ArmSession session;
  int joints;
  VectorXd q, rest, tau, all;
  veridyn::ArmState state;
  SafetyInput input;
  std::optional<ArmLoop> loop;
  std::unique_ptr<SafetySupervisor> supervisor;
  bool valid = false, lost = false;
  double heard = 0.0;  // [s] of the last valid read
};

class BoardRun {
 public:
  BoardRun(const Scenario& scenario, const std::vector<CooperatingArm>& arms,
           const BoardCooperationOptions& options, const std::atomic<bool>& stop)
      : scenario_(scenario), options_(options), stop_(stop), period_(1.0 / scenario.control.rate) {
    require(arms.size() == scenario.arms.size(), "boards: found configurations of ", arms.size(),
            " arms, expected one for each of the scenario's ", scenario.arms.size(), ".");
    require(options.force_sources.empty() ||
                options.force_sources.size() == scenario.members.size(),
            "boards: found ", options.force_sources.size(), " force sources, expected one for each of ",
            scenario.members.size(), " members.");
    require(options.emulate || !options.force_sources.empty() || scenario.members.empty(),
            "boards: found no force source, expected one for each member.");
    if (options.emulate) {
      std::vector<RobotConfig> robots;
      std::vector<MatrixXd> couplings;
      for (const CooperatingArm& arm : arms) {
        robots.push_back(arm.robot);
        couplings.push_back(arm.coupling);
      }
      joined_ = std::make_unique<JoinedArms>(scenario, robots, couplings, options.firmware);
      serving_ = std::thread([this] { joined_->run(stop_serving_); });
    }
    try {
      for (size_t k = 0; k < arms.size(); ++k)
        sides_.push_back(std::make_unique<Side>(scenario, k, arms[k], options,
                                                joined_ ? joined_->port(static_cast<int>(k)) : 0));
      open_sensors();
    } catch (...) {
      end_serving();
      throw;
    }
  }
  ~BoardRun() { end_serving(); }
  BoardRun(const BoardRun&) = delete;
  BoardRun& operator=(const BoardRun&) = delete;

  BoardCooperationRun run() {
    if (power_up()) {
      begin();
      play();
      wind_down();
    }
    for (auto& side : sides_) side->session.power_off();
    out_.off_at = time_;
    out_.force_at_off = largest_now();
    for (int k = 0; k < 20; ++k) cycle([] {});
    if (joined_) {
      out_.largest_force = std::max(out_.largest_force, joined_->largest_force());
    }
    for (auto& side : sides_) side->session.boards().shutdown();
    finish();
    return std::move(out_);
  }

 private:
  void end_serving() {
    stop_serving_.store(true);
    if (serving_.joinable()) serving_.join();
  }

  void open_sensors() {
    for (size_t k = 0; k < scenario_.members.size(); ++k) {
      if (options_.force_sources.empty()) {
        ForceSensorOptions sensor = scenario_.members[k].sensor;
        sensor.seed = scenario_.seed + 1000 + static_cast<unsigned>(k);
        simulated_.emplace_back(sensor, 0.1);
        continue;
      }
      ForceChannelOptions channel;
      if (k < options_.force_calibrations.size() && !options_.force_calibrations[k].empty())
        channel.calibration = read_load_cell(options_.force_calibrations[k]);
      channel.cutoff = scenario_.control.force_cutoff;
      channels_.push_back(
          std::make_unique<ForceChannel>(open_force_source(options_.force_sources[k]), channel));
    }
    readings_.resize(scenario_.members.size());
  }

  double clock() { return sides_.front()->link.now(); }

  // All arms are read, `work` is done, all are written. The first arm's link keeps the time.
  template <typename Work>
  void cycle(Work&& work) {
    if (next_ <= 0.0) next_ = clock();
    double now = clock();
    if (now < next_) {
      sides_.front()->link.wait(next_ - now);
      now = clock();
    } else if (now - next_ > period_) {
      ++out_.late;
      next_ = now;
    }
    dt_ = last_ > 0.0 ? now - last_ : period_;
    last_ = now;
    next_ += period_;
    for (auto& side : sides_) {
      side->valid = side->session.update();
      if (side->valid) {
        side->q = side->session.state().q.head(side->joints);
        side->heard = now;
      }
    }
    now_ = now;
    work();
    for (auto& side : sides_) side->session.commit();
    const double took = clock() - now;
    ++out_.cycles;
    out_.longest_cycle = std::max(out_.longest_cycle, took);
    out_.mean_cycle += (took - out_.mean_cycle) / static_cast<double>(out_.cycles);
  }

  bool all_ready() const {
    return std::all_of(sides_.begin(), sides_.end(),
                       [](const auto& side) { return side->session.ready(); });
  }

  bool fail(const std::string& why, int arm) {
    if (!out_.why.empty()) return false;
    out_.why = why;
    out_.faulty_arm = arm;
    out_.end = arm < 0 ? BoardEnd::kStopped : BoardEnd::kFault;
    out_.fault_at = time_;
    return false;
  }

  bool power_up() {
    for (int k = 0; k < static_cast<int>(kLooking / period_); ++k) cycle([] {});
    for (size_t k = 0; k < sides_.size(); ++k) {
      if (const char* refused = sides_[k]->session.power_on())
        return fail(refused, static_cast<int>(k));
    }
    for (auto& side : sides_) require_reading(*side);
    for (size_t k = 0; k < sides_.size(); ++k) sides_[k]->begin(scenario_, k);
    for (int k = 0; k < static_cast<int>(options_.power_timeout / period_); ++k) {
      cycle([this] {
        for (auto& side : sides_) stand(*side);
      });
      if (all_ready()) return true;
    }
    return fail("power does not come up", 0);
  }

  static void require_reading(const Side& side) {
    require(side.session.state().q.allFinite(), "arm '", side.session.robot().name,
            "': found no position, expected its boards to answer.");
  }

  // Where it stands, before the scenario begins.
  void stand(Side& side) {
    if (!side.session.ready() || !side.valid) return;
    side.loop->measure(side.q);
    side.loop->freeze();
    apply(side, TipTarget{}, Vector3d::Zero());
  }

  void apply(Side& side, const TipTarget& target, const Vector3d& exerted) {
    side.state.update(side.q, side.rest);
    side.input.dt = dt_;
    side.input.sensor_age = now_ - side.heard;
    side.input.force = exerted;
    const VectorXd& tau = side.loop->torque(target, exerted);
    side.tau = side.supervisor->update(side.state, side.input, tau);
    side.all.head(side.joints) = side.tau;
    side.session.set_torques(side.all);
  }

  void begin() {
    CooperativeOptions o;
    std::vector<Vector3d> tips;
    const ScenarioControl& c = scenario_.control;
    for (size_t k = 0; k < sides_.size(); ++k) {
      sides_[k]->begin(scenario_, k);
      sides_[k]->loop->measure(sides_[k]->q);
      tips.push_back(sides_[k]->loop->position());
      o.R_world_arm.push_back(sides_[k]->models.R_world_base_known);
    }
    o.leader = scenario_.master;
    for (const ScenarioMember& m : scenario_.members)
      o.members.push_back({m.from, m.to, m.law, member_share(scenario_, m)});
    o.period = period_;
    o.largest_force = c.largest_force;
    o.largest_force_error = c.largest_force_error;
    o.largest_age = c.largest_age;
    o.largest_error = c.largest_error;
    o.stuck_force = c.stuck_force;
    o.relief_force = c.relief_force;
    if (c.largest_energy > 0.0) o.largest_energy = c.largest_energy;
    control_ = std::make_unique<CooperativeController>(o, tips);
    input_ = std::make_unique<CooperativeInput>(static_cast<int>(tips.size()),
                                                static_cast<int>(scenario_.members.size()));
    exerted_.assign(tips.size(), Vector3d::Zero());
    bound_ = c.relief_force;
    Eigen::Index rows = 0;
    for (const ScenarioPhase& phase : scenario_.phases)
      rows += static_cast<Eigen::Index>(std::lround(phase.duration * c.rate));
    out_.run = empty_run(scenario_, "boards", rows);
    out_.cycles = out_.late = 0;
    out_.longest_cycle = out_.mean_cycle = 0.0;
    time_ = 0.0;
  }

  void read_forces() {
    for (Vector3d& f : exerted_) f.setZero();
    for (size_t k = 0; k < readings_.size(); ++k) {
      if (channels_.empty()) {
        const ForceSample sample = simulated_[k].read(time_, joined_->tension(static_cast<int>(k)));
        readings_[k] = {sample.force, time_ - sample.time, sample.number, sample.force};
      } else {
        readings_[k] = channels_[k]->update(now_);
        if (channels_[k]->state() == ForceState::kStuck) readings_[k].age = 1e3;
      }
      input_->force[k] = readings_[k];
      const ScenarioMember& m = scenario_.members[k];
      const auto from = static_cast<size_t>(m.from);
      const auto to = static_cast<size_t>(m.to);
      const Vector3d line = input_->position[to] - input_->position[from];
      const Vector3d u = line.norm() > 0.0 ? Vector3d(line.normalized()) : Vector3d::Zero();
      exerted_[from] -= readings_[k].force * u;
      exerted_[to] += readings_[k].force * u;
    }
  }

  void watch_arms() {
    for (size_t k = 0; k < sides_.size(); ++k) {
      Side& side = *sides_[k];
      if (side.lost) continue;
      const bool silent = now_ - side.heard > scenario_.control.largest_age;
      const bool off = side.session.boards().state() == PowerState::kFault;
      const SafetyFault fault = side.supervisor->fault();
      if (!silent && !off && fault == SafetyFault::kNone) continue;
      side.lost = true;
      input_->healthy[k] = 0;
      const std::string& name = scenario_.arms[k].name;
      fail(silent ? "arm " + name + ": its boards do not answer"
           : off  ? "arm " + name + ": " + describe(side.session.boards().cause())
                  : "arm " + name + ": " + describe(fault),
           static_cast<int>(k));
    }
  }

  // One cycle of the task; also while all is held.
  void work() {
    for (size_t k = 0; k < sides_.size(); ++k) {
      Side& side = *sides_[k];
      if (side.valid) side.loop->measure(side.q);
      input_->position[k] = side.loop->position();
      input_->velocity[k] = side.loop->velocity();
    }
    read_forces();
    watch_arms();
    targets_ = &control_->update(*input_);
    const bool holds = control_->state() != CooperativeState::kTracking || winding_;
    if (holds && control_->state() != CooperativeState::kTracking)
      fail(std::string("the controller ") + describe(control_->state()), 0);
    for (size_t k = 0; k < sides_.size(); ++k) {
      Side& side = *sides_[k];
      if (control_->sensor_failed()) side.loop->freeze();
      if (holds && !control_->sensor_failed()) side.loop->hold_within(bound_, exerted_[k]);
      if (side.valid && side.session.ready()) apply(side, (*targets_)[k], exerted_[k]);
    }
    const double force = largest_now();
    out_.largest_force = std::max(out_.largest_force, force);
    if (!out_.why.empty())
      out_.largest_force_after_fault = std::max(out_.largest_force_after_fault, force);
    if (joined_ && time_ >= options_.fault_at) {
      if (options_.silent_arm >= 0) joined_->silence(options_.silent_arm);
      if (options_.broken_arm >= 0) joined_->break_amplifier(options_.broken_arm);
    }
    time_ += dt_;
  }

  double largest_now() const {
    double largest = 0.0;
    for (size_t k = 0; k < readings_.size(); ++k)
      largest = std::max(largest, std::abs(joined_ ? joined_->tension(static_cast<int>(k))
                                                   : readings_[k].force));
    return largest;
  }

  void record(Eigen::Index k) {
    ScenarioRun& run = out_.run;
    run.time[k] = time_;
    for (size_t i = 0; i < sides_.size(); ++i) {
      ArmTrace& trace = run.arm[i];
      trace.q.row(k) = sides_[i]->q.transpose();
      trace.tau.row(k) = sides_[i]->tau.transpose();
      trace.tip.row(k) = sides_[i]->loop->position().transpose();
      trace.motion.row(k) = (*targets_)[i].motion.transpose();
      trace.target.row(k) = (*targets_)[i].position.transpose();
    }
    for (size_t i = 0; i < readings_.size(); ++i) {
      MemberTrace& trace = run.member[i];
      trace.wanted[k] = control_->wanted_force(static_cast<int>(i));
      trace.force[k] = joined_ ? joined_->tension(static_cast<int>(i)) : readings_[i].force;
      trace.measured[k] = readings_[i].force;
      trace.x_f[k] = control_->correction(static_cast<int>(i));
      trace.tracked[k] = 1.0;
    }
  }

  void play() {
    for (const ScenarioPhase& phase : scenario_.phases) {
      for (const ScenarioCommand& c : phase.commands) give_command(c, *control_);
      const Eigen::Index first = row_;
      const auto rows = static_cast<Eigen::Index>(std::lround(phase.duration * scenario_.control.rate));
      for (Eigen::Index k = 0; k < rows; ++k) {
        cycle([this] { work(); });
        record(row_++);
        if (stop_.load(std::memory_order_relaxed)) fail("stopped by a signal", -1);
        if (!out_.why.empty()) break;
      }
      if (row_ > first) phases_.push_back({&phase, first, row_});
      if (!out_.why.empty()) return;
    }
  }

  // Hold, then release the pretension, then let power go.
  void wind_down() {
    out_.run.state = control_->state();
    out_.run.held_at = out_.fault_at;
    control_->stop();
    winding_ = true;
    const double relief = scenario_.control.relief_force;
    const auto holding = static_cast<int>((out_.why.empty() ? 0.2 : options_.hold) / period_);
    for (int k = 0; k < holding; ++k) cycle([this] { work(); });
    const auto releasing = static_cast<int>(options_.release / period_);
    for (int k = 0; k < releasing; ++k) {
      const double share = static_cast<double>(k) / std::max(1, releasing);
      bound_ = std::max(kLeastForce, relief * (1.0 - share));
      cycle([this] { work(); });
    }
  }

  void finish() {
    cut(out_.run, row_);
    for (const Span& span : phases_)
      out_.run.phases.push_back(
          phase_figures(scenario_, *span.phase, out_.run, span.first, span.end));
    for (const MemberTrace& m : out_.run.member) {
      if (m.force.size() > 0)
        out_.run.largest_force = std::max(out_.run.largest_force, m.force.cwiseAbs().maxCoeff());
    }
    out_.run.largest_force = std::max(out_.run.largest_force, out_.largest_force);
    out_.run.asked_largest_force = scenario_.asked_largest_force;
  }

  struct Span {
    const ScenarioPhase* phase;
    Eigen::Index first, end;
  };

  const Scenario& scenario_;
  BoardCooperationOptions options_;
  const std::atomic<bool>& stop_;
  double period_;
  std::unique_ptr<JoinedArms> joined_;
  std::thread serving_;
  std::atomic<bool> stop_serving_{false};
  std::vector<std::unique_ptr<Side>> sides_;
  std::vector<ForceSensor> simulated_;
  std::vector<std::unique_ptr<ForceChannel>> channels_;
  std::vector<ForceReading> readings_;
  std::unique_ptr<CooperativeController> control_;
  std::unique_ptr<CooperativeInput> input_;
  const std::vector<TipTarget>* targets_ = nullptr;
  std::vector<Vector3d> exerted_;
  std::vector<Span> phases_;
  BoardCooperationRun out_;
  Eigen::Index row_ = 0;
  double next_ = 0.0, last_ = 0.0, now_ = 0.0, dt_ = 0.0, time_ = 0.0, bound_ = 5.0;
  bool winding_ = false;
};

}  // namespace

BoardCooperationRun run_on_boards(const Scenario& scenario, const std::vector<CooperatingArm>& arms,
                                  const BoardCooperationOptions& options,
                                  const std::atomic<bool>& stop) {
  require(scenario.bodies.empty() && scenario.walls.empty(), "boards: scenario '", scenario.name,
          "': found walls or bodies, expected members between arms alone.");
  return BoardRun(scenario, arms, options, stop).run();
}

std::string BoardCooperationRun::report() const {
  std::string out = run.report();
  out += fmt::format("{} cycles, {} late; a cycle took {:.0f} us, at most {:.0f} us.\n", cycles, late,
                     1e6 * mean_cycle, 1e6 * longest_cycle);
  if (end != BoardEnd::kDone)
    out += fmt::format("At {:.4g} s {}: all arms held, gave up the pretension, and were without "
                       "power at {:.4g} s; at most {:.3g} N after the fault, {:.3g} N at the end.\n",
                       fault_at, why, off_at, largest_force_after_fault, force_at_off);
  return out;
}

}  // namespace veridyn::dvrk
