#include "dvrk/cooperation/board_cooperation.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <thread>

#include "board_side.hpp"
#include "cooperation/empty_run.hpp"
#include "cooperation/loop_gains.hpp"
#include "cooperation/phase_commands.hpp"
#include "cooperation/phase_figures.hpp"
#include "joined_arms.hpp"
#include "veridyn/control/load_cell.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

using Eigen::Vector3d;

constexpr double kLooking = 0.1;     // [s] of reading before power is asked for
constexpr double kSettled = 0.2;     // [s] at rest after the last phase
constexpr double kAfter = 0.02;      // [s] of reading after power went
constexpr double kLeastForce = 0.3;  // [N] of pretension that is left before power goes
constexpr double kNever = 1e3;       // [s] age of a reading that is not to be believed

class BoardRun {
 public:
  BoardRun(const Scenario& scenario, const std::vector<CooperatingArm>& arms,
           const BoardCooperationOptions& options, const std::atomic<bool>& stop)
      : scenario_(scenario), options_(options), stop_(stop), period_(1.0 / scenario.control.rate) {
    check(arms);
    if (options.emulate) join(arms);
    try {
      for (size_t k = 0; k < arms.size(); ++k)
        sides_.push_back(
            std::make_unique<BoardSide>(scenario, k, arms[k], options, link_to(arms[k], k)));
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
    for (auto& side : sides_) side->session().power_off();
    out_.off_at = time_;
    out_.force_at_off = largest_now();
    repeat(kAfter, [] {});
    out_.power = OffState::kConfirmed;
    for (auto& side : sides_)
      out_.power = std::max(out_.power, side->session().boards().shutdown());
    if (joined_) out_.largest_force = std::max(out_.largest_force, joined_->largest_force());
    finish();
    return std::move(out_);
  }

 private:
  void check(const std::vector<CooperatingArm>& arms) const {
    require(arms.size() == scenario_.arms.size(), "boards: found configurations of ", arms.size(),
            " arms, expected one for each of the scenario's ", scenario_.arms.size(), ".");
    require(options_.force_sources.empty() ||
                options_.force_sources.size() == scenario_.members.size(),
            "boards: found ", options_.force_sources.size(),
            " force sources, expected one for each of ", scenario_.members.size(), " members.");
    require(options_.emulate || !options_.force_sources.empty() || scenario_.members.empty(),
            "boards: found no force source, expected one for each member.");
    require(options_.emulate || (!options_.stepped && options_.faults.empty()),
            "boards: found a stepped clock or faults, expected them of emulated boards alone.");
  }

  void join(const std::vector<CooperatingArm>& arms) {
    std::vector<RobotConfig> robots;
    std::vector<MatrixXd> couplings;
    for (const CooperatingArm& arm : arms) {
      robots.push_back(arm.robot);
      couplings.push_back(arm.coupling);
    }
    for (const ScenarioFault& fault : scenario_.faults) {
      if (fault.kind == ScenarioFault::Kind::kArmLimp)
        options_.faults.push_back({EmulatedFault::Kind::kLimp, fault.arm, fault.at});
    }
    joined_ = std::make_unique<JoinedArms>(scenario_, robots, couplings, options_.firmware);
    if (!options_.stepped) serving_ = std::thread([this] { joined_->run(stop_serving_); });
  }

  std::unique_ptr<DatagramLink> link_to(const CooperatingArm& arm, std::size_t k) {
    if (!joined_) return std::make_unique<UdpLink>(arm.host, arm.port);
    const std::uint16_t port = joined_->port(static_cast<int>(k));
    if (options_.stepped) return std::make_unique<SteppedLink>(port, *joined_);
    return std::make_unique<UdpLink>("127.0.0.1", port);
  }

  void end_serving() {
    stop_serving_.store(true);
    if (serving_.joinable()) serving_.join();
  }

  void open_sensors() {
    for (size_t k = 0; k < scenario_.members.size(); ++k) {
      if (options_.force_sources.empty()) {
        simulated_.emplace_back(sensor_options(scenario_, static_cast<int>(k)), 0.1);
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
    exerted_.assign(sides_.size(), Vector3d::Zero());
    ages_.assign(sides_.size(), 0.0);
  }

  double clock() { return sides_.front()->link().now(); }

  // All arms are read, `work` is done, all are written. The first arm's link keeps the time.
  template <typename Work>
  void cycle(Work&& work) {
    double now = clock();
    if (next_ <= 0.0) next_ = now;
    if (now < next_) {
      sides_.front()->link().wait(next_ - now);
      now = clock();
    } else if (now - next_ > period_) {
      ++out_.late;
      next_ = now;
    }
    dt_ = last_ > 0.0 ? now - last_ : period_;
    last_ = now;
    next_ += period_;
    for (auto& side : sides_) side->read(now);
    now_ = now;
    work();
    for (auto& side : sides_) side->write();
    const double took = clock() - now;
    ++out_.cycles;
    out_.longest_cycle = std::max(out_.longest_cycle, took);
    out_.mean_cycle += (took - out_.mean_cycle) / static_cast<double>(out_.cycles);
    time_ += dt_;
  }

  // Cycles for so long; by the clock, since cycles may be late.
  template <typename Work>
  void repeat(double seconds, Work&& work) {
    for (const double until = time_ + seconds; time_ < until;) cycle(work);
  }

  // The first cause counts.
  bool fail(const char* why, int arm, BoardEnd end = BoardEnd::kFault) noexcept {
    if (why_ != nullptr) return false;
    why_ = why;
    out_.faulty_arm = arm;
    out_.end = end;
    out_.fault_at = time_;
    return false;
  }

  bool power_up() {
    repeat(kLooking, [] {});
    for (size_t k = 0; k < sides_.size(); ++k) {
      if (const char* refused = sides_[k]->session().power_on())
        return fail(refused, static_cast<int>(k));
    }
    for (size_t k = 0; k < sides_.size(); ++k) sides_[k]->begin(scenario_, k);
    const double until = time_ + options_.power_timeout;
    while (time_ < until) {
      cycle([this] {
        for (auto& side : sides_) {  // where they stand, before the scenario begins
          side->loop().freeze();
          side->act(TipTarget{}, Vector3d::Zero(), 0.0, dt_);
        }
      });
      if (std::all_of(sides_.begin(), sides_.end(),
                      [](const auto& side) { return side->session().ready(); }))
        return true;
    }
    for (size_t k = 0; k < sides_.size(); ++k) {
      if (!sides_[k]->session().ready())
        return fail("its power does not come up", static_cast<int>(k));
    }
    return false;
  }

  void begin() {
    std::vector<Vector3d> tips;
    std::vector<Eigen::Matrix3d> bases;
    for (size_t k = 0; k < sides_.size(); ++k) {
      sides_[k]->begin(scenario_, k);
      tips.push_back(sides_[k]->loop().position());
      bases.push_back(sides_[k]->models().R_world_base_known);
    }
    control_ =
        std::make_unique<CooperativeController>(cooperative_options(scenario_, bases), tips);
    input_ = std::make_unique<CooperativeInput>(static_cast<int>(tips.size()),
                                                static_cast<int>(scenario_.members.size()));
    bound_ = scenario_.control.relief_force;
    Eigen::Index rows = 0;
    for (const ScenarioPhase& phase : scenario_.phases) rows += rows_of(phase);
    out_.run = empty_run(scenario_, "boards", rows);
    spans_.reserve(scenario_.phases.size());
    out_.cycles = out_.late = 0;
    out_.longest_cycle = out_.mean_cycle = 0.0;
    time_ = 0.0;
  }

  Eigen::Index rows_of(const ScenarioPhase& phase) const {
    return static_cast<Eigen::Index>(std::lround(phase.duration * scenario_.control.rate));
  }

  void read_forces() noexcept {
    for (Vector3d& f : exerted_) f.setZero();
    std::fill(ages_.begin(), ages_.end(), 0.0);
    for (size_t k = 0; k < readings_.size(); ++k) {
      if (channels_.empty()) {
        const ForceSample sample = simulated_[k].read(time_, joined_->tension(static_cast<int>(k)));
        readings_[k] = {sample.force, time_ - sample.time, sample.number, sample.force};
      } else {
        readings_[k] = channels_[k]->update(now_);
        if (channels_[k]->state() == ForceState::kStuck) readings_[k].age = kNever;
      }
      input_->force[k] = readings_[k];
      const ScenarioMember& m = scenario_.members[k];
      const auto from = static_cast<size_t>(m.from);
      const auto to = static_cast<size_t>(m.to);
      const Vector3d line = input_->position[to] - input_->position[from];
      const Vector3d u = line.norm() > 0.0 ? Vector3d(line.normalized()) : Vector3d::Zero();
      exerted_[from] -= readings_[k].force * u;
      exerted_[to] += readings_[k].force * u;
      if (readings_[k].number < 0) continue;  // nothing yet: the controller's own patience
      ages_[from] = std::max(ages_[from], readings_[k].age);
      ages_[to] = std::max(ages_[to], readings_[k].age);
    }
  }

  void watch_arms() noexcept {
    for (size_t k = 0; k < sides_.size(); ++k) {
      if (const char* why = sides_[k]->lost_by(scenario_.control.largest_age)) {
        input_->healthy[k] = 0;
        fail(why, static_cast<int>(k));
      }
    }
  }

  // One cycle of the task; also while all is held.
  void work() noexcept {
    for (size_t k = 0; k < sides_.size(); ++k) {
      input_->position[k] = sides_[k]->loop().position();
      input_->velocity[k] = sides_[k]->loop().velocity();
    }
    read_forces();
    watch_arms();
    targets_ = &control_->update(*input_);
    const CooperativeState state = control_->state();
    if (state != CooperativeState::kTracking) fail(describe(state), -1);
    const bool holds = state != CooperativeState::kTracking || winding_;
    for (size_t k = 0; k < sides_.size(); ++k) {
      BoardSide& side = *sides_[k];
      if (control_->sensor_failed()) {
        side.loop().freeze();
      } else if (holds && scenario_.control.guard) {
        side.loop().hold_within(bound_, exerted_[k]);
      }
      side.act((*targets_)[k], exerted_[k], ages_[k], dt_);
    }
    const double force = largest_now();
    out_.largest_force = std::max(out_.largest_force, force);
    if (why_ != nullptr)
      out_.largest_force_after_fault = std::max(out_.largest_force_after_fault, force);
    for (const EmulatedFault& fault : options_.faults) {
      if (time_ >= fault.at) joined_->break_down(fault);
    }
  }

  double largest_now() const noexcept {
    double largest = 0.0;
    for (size_t k = 0; k < readings_.size(); ++k)
      largest = std::max(largest, std::abs(joined_ ? joined_->tension(static_cast<int>(k))
                                                   : readings_[k].force));
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
      const Eigen::Index rows = rows_of(phase);
      for (Eigen::Index k = 0; k < rows && why_ == nullptr; ++k) {
        cycle([this] { work(); });
        record(row_++);
        if (stop_.load(std::memory_order_relaxed)) fail("stopped by a signal", -1, BoardEnd::kStopped);
      }
      if (row_ > first) spans_.push_back({&phase, first, row_});
      if (why_ != nullptr) return;
    }
  }

  // Hold, then release the pretension, then let power go.
  void wind_down() {
    out_.run.state = control_->state();
    out_.run.held_at = out_.fault_at;
    control_->stop();
    winding_ = true;
    repeat(why_ == nullptr ? kSettled : options_.hold, [this] { work(); });
    out_.release_at = time_;
    out_.force_at_release = largest_now();
    const double relief = scenario_.control.relief_force;
    repeat(options_.release, [this, relief] {
      const double share = (time_ - out_.release_at) / options_.release;
      bound_ = std::max(kLeastForce, relief * (1.0 - share));
      control_->relieve_beyond(bound_);
      work();
    });
  }

  void finish() {
    if (why_ != nullptr) {
      const std::string who =
          out_.faulty_arm >= 0
              ? "arm " + scenario_.arms[static_cast<size_t>(out_.faulty_arm)].name + ": "
          : out_.end == BoardEnd::kStopped ? ""
                                           : "the controller ";
      out_.why = who + why_;
    }
    if (out_.run.arm.empty()) out_.run = empty_run(scenario_, "boards", 0);  // power never came
    cut(out_.run, row_);
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

  const Scenario& scenario_;
  BoardCooperationOptions options_;
  const std::atomic<bool>& stop_;
  double period_;
  std::unique_ptr<JoinedArms> joined_;
  std::thread serving_;
  std::atomic<bool> stop_serving_{false};
  std::vector<std::unique_ptr<BoardSide>> sides_;
  std::vector<ForceSensor> simulated_;
  std::vector<std::unique_ptr<ForceChannel>> channels_;
  std::vector<ForceReading> readings_;
  std::unique_ptr<CooperativeController> control_;
  std::unique_ptr<CooperativeInput> input_;
  const std::vector<TipTarget>* targets_ = nullptr;
  std::vector<Vector3d> exerted_;
  std::vector<double> ages_;
  std::vector<Span> spans_;
  BoardCooperationRun out_;
  const char* why_ = nullptr;
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

}  // namespace veridyn::dvrk
