#include "dvrk/cooperation/board_teleoperation.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "board_loop.hpp"
#include "veridyn/control/gravity_compensation.hpp"
#include "veridyn/control/load_cell.hpp"
#include "veridyn/control/quintic_interpolator.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

using Eigen::Vector3d;

constexpr double kLargestLatency = 0.06;  // [s] end of the search

// The leader: gravity is compensated, with forces at its tip and brakes for joints that do not move the tip.
class LeaderLoop {
 public:
  LeaderLoop(const Model& model, const Tip& tip, const VectorXd& q)
      : state_(model, tip), gravity_(model), rest_(q), tau_(VectorXd::Zero(q.size())) {}

  // Torques (n) with `force` on the tip [N], in the base.
  const VectorXd& torque(const VectorXd& q, const VectorXd& dq, const Vector3d& force) noexcept {
    state_.update(q, dq);
    tau_ = gravity_.update(q);
    tau_.noalias() += state_.tip().jacobian().topRows<3>().transpose() * force;
    // Joints that do not move the tip hold their position.
    for (Eigen::Index j = 0; j < q.size(); ++j) {
      if (state_.tip().jacobian().col(j).head<3>().squaredNorm() < kIdle)
        tau_[j] += kIdleStiffness * (rest_[j] - q[j]) - kIdleDamping * dq[j];
    }
    return tau_;
  }

 private:
  static constexpr double kIdle = 1e-12;
  static constexpr double kIdleStiffness = 1.0, kIdleDamping = 0.05;  // [N m/rad], [N m s/rad]
  veridyn::ArmState state_;
  GravityCompensation gravity_;
  VectorXd rest_, tau_;
};

class TeleoperationLoop : private BoardLoop {
 public:
  TeleoperationLoop(const TeleoperationScenario& wanted, const std::vector<CooperatingArm>& arms,
                    const BoardCooperationOptions& options, const std::atomic<bool>& stop)
      : BoardLoop(wanted.scenario, arms, options, stop),
        wanted_(wanted),
        leader_(static_cast<std::size_t>(wanted.leader)),
        follower_(static_cast<std::size_t>(wanted.follower)) {
    const std::size_t walls = scenario_.walls.size();
    require(options_.force_sources.size() == (options_.emulate ? 0 : walls),
            "boards: found ", options_.force_sources.size(), " force sources, expected ",
            options_.emulate ? "none with emulated boards." : "one for the wall.");
    for (const ScenarioWall& wall : scenario_.walls) {
      require(wall.sensor_axes == 1, "teleoperation: found a sensor of three axes at '", wall.name,
              "', expected one axis, along the wall's normal.");
      if (options_.emulate) {
        sensor_.emplace(wall.sensor, 0.1);
      } else {
        line_.push_back(open_sensor(options_.force_sources.front(), "the wall", wall.sensor.rate));
      }
    }
  }

  TeleoperationRun run() {
    out_.name = scenario_.name;
    read_before_power();
    plan();
    read_before_power();
    wait_for_sensors(line_);
    if (stopped()) fail("stopped by a signal", {}, BoardEnd::kStopped);
    if (why_ == nullptr && power_up(line_)) {
      begin();
      play();
      holds_ = true;
      repeat(why_ == nullptr ? 0.1 : options_.hold, [this] { work(); });
    }
    out_.power = power_down();
    out_.end = end_;
    out_.why = cause();
    out_.after_fault = after_fault();
    out_.later = later_faults();
    out_.not_off = not_off_;
    out_.fault_at = fault_at_;
    out_.cycles = timing_.cycles;
    out_.late = timing_.late;
    if (joined_) out_.largest_force = joined_->largest_force();
    finish();
    return std::move(out_);
  }

 private:
  BoardSide& leader() { return *sides_[leader_]; }
  BoardSide& follower() { return *sides_[follower_]; }

  // An operator's motion is unknown. The steps of an emulated hand are known, and rejected if the follower
  // cannot execute them.
  void plan() {
    if (!options_.planned || !options_.emulate) return;
    MotionPlan plan(scenario_, planned_arms());
    MotionPlan::State state = plan.initial_state(initial_state());
    for (std::size_t p = 0; p < scenario_.phases.size(); ++p) {
      const TeleoperationStep& step = wanted_.steps[p];
      ScenarioCommand hand;
      hand.kind = ScenarioCommand::Kind::kMoveArm;
      hand.arm = wanted_.leader;
      hand.way = step.way;
      hand.over = step.over;
      ScenarioCommand tip = hand;
      tip.arm = wanted_.follower;
      tip.way = wanted_.options.scale * (wanted_.options.R_follower_leader * step.way);
      std::vector<ScenarioCommand> commands{hand};
      if (step.clutch) commands.push_back(tip);
      require_feasible(p, state.time, plan.play(state, commands, scenario_.phases[p].duration));
    }
  }

  void begin() {
    for (std::size_t k = 0; k < sides_.size(); ++k) sides_[k]->begin(scenario_, k);
    const ScenarioArm& arm = scenario_.arms[leader_];
    loop_.emplace(leader().models().known, Tip{arm.frame, arm.offset}, leader().q());
    tele_.emplace(wanted_.options, leader().loop().position(), follower().loop().position());
    hand_.emplace(VectorXd(leader().loop().position()));
    goal_ = hand_->x();
    if (joined_)
      joined_->attach_hand({wanted_.leader, wanted_.hand_stiffness, wanted_.hand_damping},
                            leader().loop().position());
    double seconds = 0.0;
    for (const ScenarioPhase& phase : scenario_.phases) seconds += phase.duration;
    rows_ = MatrixXd::Zero(static_cast<Eigen::Index>(std::ceil(seconds / period_)) + 1, 15);
  }

  void play() {
    for (std::size_t p = 0; p < scenario_.phases.size(); ++p) {
      const TeleoperationStep& step = wanted_.steps[p];
      goal_ += step.way;
      hand_->move_to(goal_, step.over);
      tele_->clutch(step.clutch);
      const Eigen::Index first = row_;
      const auto cycles =
          static_cast<Eigen::Index>(std::lround(scenario_.phases[p].duration / period_));
      for (Eigen::Index k = 0; k < cycles && why_ == nullptr; ++k) {
        cycle([this] { work(); });
        record();
        if (stopped()) fail("stopped by a signal", {}, BoardEnd::kStopped);
      }
      spans_.push_back({first, row_});
      if (why_ != nullptr) return;
    }
  }

  // Force of the follower's tip on the wall, in the world.
  Vector3d read_force() noexcept {
    if (scenario_.walls.empty()) return Vector3d::Zero();
    if (joined_) {
      const ForceSample sample = sensor_->read(time_, joined_->true_wall_force(0));
      force_ = {sample.force, time_ - sample.time, sample.number, sample.force};
    } else {
      force_ = read_sensor(line_.front());
    }
    if (!(force_.age <= scenario_.control.largest_age))
      fail("holds: a force sensor's samples are too old", {});
    if (!(std::abs(force_.force) <= scenario_.control.largest_force))
      fail("holds: a force is too large", {});
    return -force_.force * scenario_.walls.front().normal;
  }

  // One cycle of both arms, under power.
  void work() noexcept {
    if (joined_) {
      hand_->advance(period_);
      joined_->move_hand_to(hand_->x());
    }
    const Vector3d force = read_force();
    for (std::size_t k = 0; k < sides_.size(); ++k) collect_faults(k);
    if (why_ != nullptr || holds_) tele_->clutch(false);
    tele_->update(leader().loop().position(), leader().loop().velocity(), force);
    // While targets are held the follower must come to rest; the leader is free.
    follower().set_held((why_ != nullptr || holds_) && !follower().loop().yields());
    watch_hold();
    follower().act(tele_->follower(), force, force_.age, dt_);
    const Vector3d in_base =
        leader().models().R_world_base_known.transpose() * tele_->leader_force();
    leader().drive(loop_->torque(leader().q(), leader().dq(), in_base), Vector3d::Zero(), 0.0, dt_);
    if (joined_) activate_fault();
  }

  // Stores this cycle as the next row, see TeleoperationRun::rows.
  void record() noexcept {
    if (row_ >= rows_.rows()) return;
    auto row = rows_.row(row_++);
    row[0] = time_;
    row.segment<3>(1) = leader().loop().position().transpose();
    row.segment<3>(4) = tele_->follower().position.transpose();
    row.segment<3>(7) = follower().loop().position().transpose();
    row[10] = joined_ && !scenario_.walls.empty() ? joined_->true_wall_force(0) : force_.force;
    if (joined_) row.segment<3>(11) = joined_->hand_force().transpose();
    row[14] = tele_->is_engaged() ? 1.0 : 0.0;
  }

  void finish() {
    rows_.conservativeResize(row_, rows_.cols());
    out_.rows = rows_;
    for (std::size_t p = 0; p < spans_.size(); ++p) phase_figures(p);
    out_.latency = latency();
  }

  // Appends the results of phase p; zeros if it has no rows.
  void phase_figures(std::size_t p) {
    const auto [first, end] = spans_[p];
    const Eigen::Index count = end - first;
    out_.phases.push_back(scenario_.phases[p].name);
    if (count == 0) {
      for (auto* list : {&out_.tracking_rms, &out_.tracking_largest, &out_.follower_moved,
                         &out_.force_follower, &out_.force_hand})
        list->push_back(0.0);
      return;
    }
    const MatrixXd error = rows_.block(first, 4, count, 3) - rows_.block(first, 7, count, 3);
    out_.tracking_rms.push_back(std::sqrt(error.squaredNorm() / static_cast<double>(count)));
    out_.tracking_largest.push_back(error.rowwise().norm().maxCoeff());
    const MatrixXd ways =
        rows_.block(first, 7, count, 3).rowwise() - rows_.block(first, 7, 1, 3).row(0);
    out_.follower_moved.push_back(ways.rowwise().norm().maxCoeff());
    const Eigen::Index last = std::max<Eigen::Index>(1, count / 5);
    out_.force_follower.push_back(rows_.block(end - last, 10, last, 1).mean());
    out_.force_hand.push_back(rows_.block(end - last, 11, last, 3).colwise().mean().norm());
  }

  // [s] The delay at which scaled leader and follower differ least, to a tenth of a cycle; nullopt: no free phase.
  std::optional<double> latency() const {
    const TeleoperationOptions& o = wanted_.options;
    const double most = kLargestLatency / period_;  // [cycles]
    const auto spared = static_cast<Eigen::Index>(std::ceil(most));
    std::optional<double> best;
    double least = 0.0;
    for (double shift = 0.0; shift <= most; shift += 0.1) {
      double sum = 0.0;
      bool any = false;
      for (std::size_t p = 0; p < spans_.size(); ++p) {
        const auto [first, end] = spans_[p];
        const bool counts = wanted_.steps[p].clutch && end > first &&
                            rows_.block(first, 10, end - first, 1).cwiseAbs().maxCoeff() == 0.0;
        if (!counts) continue;
        const Vector3d leader0 = rows_.block(first, 1, 1, 3).transpose();
        const Vector3d follower0 = rows_.block(first, 7, 1, 3).transpose();
        for (Eigen::Index k = first + spared; k < end; k += 5) {
          any = true;
          const double at = static_cast<double>(k) - shift;
          const auto i = static_cast<Eigen::Index>(std::floor(at));
          const double part = at - static_cast<double>(i);
          const Eigen::Index next = std::min(i + 1, end - 1);
          const Vector3d led = (1.0 - part) * rows_.block(i, 1, 1, 3).transpose() +
                               part * rows_.block(next, 1, 1, 3).transpose();
          const Vector3d follower = rows_.block(k, 7, 1, 3).transpose();
          sum += (follower - follower0 - o.scale * (o.R_follower_leader * (led - leader0)))
                     .squaredNorm();
        }
      }
      if (any && (!best || sum < least)) {
        least = sum;
        best = shift * period_;
      }
    }
    return best;
  }

  struct Span {
    Eigen::Index first, end;
  };
  const TeleoperationScenario& wanted_;
  std::size_t leader_, follower_;
  std::optional<LeaderLoop> loop_;
  std::optional<Teleoperation> tele_;
  std::optional<QuinticInterpolator> hand_;
  VectorXd goal_;
  std::optional<ForceSensor> sensor_;
  std::vector<Sensor> line_;  // empty with emulated boards
  ForceReading force_;
  MatrixXd rows_;
  std::vector<Span> spans_;
  TeleoperationRun out_;
  Eigen::Index row_ = 0;
  bool holds_ = false;
};

}  // namespace

TeleoperationRun teleoperate_on_boards(const TeleoperationScenario& scenario,
                                       const std::vector<CooperatingArm>& arms,
                                       const BoardCooperationOptions& options,
                                       const std::atomic<bool>& stop) {
  require(scenario.scenario.members.empty() && scenario.scenario.bodies.empty(),
          "boards: scenario '", scenario.scenario.name,
          "': found members or bodies, expected a leader and a follower alone.");
  return TeleoperationLoop(scenario, arms, options, stop).run();
}

}  // namespace veridyn::dvrk
