#include "emulator/joined_arms.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "cooperation/end_stops.hpp"
#include "cooperation/scenario/scenario_models.hpp"
#include "veridyn/dvrk/run/arm_session.hpp"

namespace veridyn::dvrk {
namespace {

using Clock = std::chrono::steady_clock;
using Kind = EmulatedFault::Kind;

constexpr double kStep = 5e-4;         // [s] simulated time between two polls of the sockets
constexpr double kMostBehind = 0.02;   // [s] largest delay that is made up for after a pause of the machine
constexpr double kBrake = 2.0 * M_PI * 20.0;  // [rad/s] bandwidth of the brakes that hold an arm
constexpr double kSlip = 0.05;         // [rad], [m] by which an encoder jumps

// Boards of the robot in ascending ids.
std::vector<BoardSetup> setups(const RobotConfig& robot, const BoardCooperationOptions& options) {
  std::vector<BoardSetup> out;
  for (const int id : boards_of(robot)) {
    BoardSetup setup;
    setup.id = id;
    setup.firmware = options.firmware;
    setup.current_noise = options.current_noise;
    out.push_back(setup);
  }
  return out;
}

bool has_brakes(const RobotConfig& robot) {
  return std::any_of(robot.actuators.begin(), robot.actuators.end(),
                     [](const ActuatorConfig& a) { return a.brake.has_value(); });
}

}  // namespace

JoinedArms::JoinedArms(const Scenario& scenario, const std::vector<CooperatingArm>& arms,
                       const BoardCooperationOptions& options)
    : stepped_(options.stepped),
      experiment_(scenario, "veridyn"),
      tension_(scenario.members.size()),
      rate_(scenario.members.size()),
      push_(3 * scenario.walls.size()),
      faults_(scenario.arms.size()),
      applied_(scenario.arms.size(), 0) {
  for (size_t k = 0; k < arms.size(); ++k) {
    const ScenarioArm& arm = scenario.arms[k];
    const RobotConfig& robot = arms[k].robot;
    states_.emplace_back(experiment_.real(static_cast<int>(k)), Tip{arm.frame, arm.offset});
    brakes_.push_back(arm.start);
    R_world_base_.push_back(base_rotation(arm.turn));
    tips_.push_back({static_cast<int>(k), *experiment_.real(static_cast<int>(k)).find_frame(arm.frame),
                     arm.offset});
    tau_.push_back(VectorXd::Zero(arm.start.size()));
    joints_.push_back(std::make_unique<Joint>(experiment_.world(), static_cast<int>(k)));
    emulators_.push_back(std::make_unique<BoardEmulator>(setups(robot, options)));
    loads_.push_back(std::make_unique<SimulatedArm>(*joints_[k], robot, arms[k].coupling,
                                                    boards_of(robot), arm.start));
    loads_.back()->set_sensors(JointSensors(experiment_.real(static_cast<int>(k))));
    sockets_.push_back(sockets_of(robot).front());
    slips_.push_back(std::llround(kSlip / std::abs(robot.actuators.front().bits_to_position)));
    if (!has_brakes(robot)) loads_[k]->falls_without_power();
    servers_.push_back(std::make_unique<BoardServer>(*emulators_[k], 0));
    emulators_[k]->attach(loads_[k].get());
  }
}

void JoinedArms::advance(double seconds) {
  World& world = experiment_.world();
  for (size_t k = 0; k < joints_.size(); ++k) {
    const auto arm = static_cast<int>(k);
    const VectorXd& q = world.q(arm);
    if (joints_[k]->driven()) {
      tau_[k] = joints_[k]->tau();
      if (has(k, Kind::kLimp)) tau_[k].setZero();
      if (has(k, Kind::kWeak)) tau_[k] *= 0.5;
      if (has(k, Kind::kReversed)) tau_[k] = -tau_[k];
      brakes_[k] = q;
      continue;
    }
    const VectorXd& dq = world.dq(arm);
    states_[k].update(q, dq);
    tau_[k] = states_[k].bias() + states_[k].mass_matrix() *
                                      (kBrake * kBrake * (brakes_[k] - q) - 2.0 * kBrake * dq);
  }
  if (led_.load()) move_hand();
  world.step(tau_, seconds);
  for (size_t k = 0; k < joints_.size(); ++k) {
    stop_at_ends(world, experiment_.real(static_cast<int>(k)), static_cast<int>(k));
    joints_[k]->moved(seconds);
  }
  for (size_t k = 0; k < tension_.size(); ++k) {
    const World::MemberState& member = world.member(static_cast<int>(k));
    const double tension = member.tension;
    tension_[k].store(tension);
    rate_[k].store(member.rate);
    largest_force_.store(std::max(largest_force_.load(), std::abs(tension)));
  }
  for (size_t k = 0; k < push_.size() / 3; ++k) {
    const Eigen::Vector3d channels = experiment_.wall_channels_now(static_cast<int>(k));
    for (size_t c = 0; c < 3; ++c) push_[3 * k + c].store(channels[static_cast<Eigen::Index>(c)]);
    largest_force_.store(std::max(largest_force_.load(), channels.norm()));
  }
  if (watcher_) show();
}

void JoinedArms::watch(std::function<void(const EmulatedInstant&)> watcher) {
  watcher_ = std::move(watcher);
  instant_.arms.resize(joints_.size());
}

bool JoinedArms::drives_current(std::size_t arm) {
  BoardEmulator& boards = *emulators_[arm];
  for (int b = 0; b < boards.boards(); ++b)
    for (int c = 0; c < kChannels; ++c)
      if (boards.board(b).amp_on(c)) return true;
  return false;
}

void JoinedArms::show() {
  const World& world = experiment_.world();
  instant_.time = world.time();
  instant_.force = 0.0;
  for (const auto* forces : {&tension_, &push_})
    for (const std::atomic<double>& force : *forces)
      instant_.force = std::max(instant_.force, std::abs(force.load()));
  for (size_t k = 0; k < joints_.size(); ++k) {
    EmulatedInstant::Arm& arm = instant_.arms[k];
    const auto index = static_cast<int>(k);
    arm.q = &world.q(index);
    arm.dq = &world.dq(index);
    arm.tau = &tau_[k];
    arm.driven = drives_current(k);
  }
  watcher_(instant_);
}

void JoinedArms::move_hand() {
  const auto k = static_cast<size_t>(hand_.arm);
  World& world = experiment_.world();
  const World::PointMotion tip = world.point(tips_[k]);
  const Eigen::Vector3d place{place_[0].load(), place_[1].load(), place_[2].load()};
  const Eigen::Vector3d force =
      hand_.stiffness * (place - tip.position) - hand_.damping * tip.velocity;
  for (int i = 0; i < 3; ++i) hand_force_[i].store(force[i]);
  states_[k].update(world.q(hand_.arm), world.dq(hand_.arm));
  const Eigen::Vector3d in_base = R_world_base_[k].transpose() * force;
  tau_[k] += states_[k].tip().jacobian().topRows<3>().transpose() * in_base;
}

void JoinedArms::apply_faults() {
  for (size_t k = 0; k < emulators_.size(); ++k) {
    const unsigned now = faults_[k].load();
    const unsigned fresh = now & ~applied_[k];
    if (fresh == 0) continue;
    applied_[k] = now;
    BoardEmulator& boards = *emulators_[k];
    const auto begins = [fresh](Kind kind) { return (fresh & bit_of(kind)) != 0; };
    if (begins(Kind::kSilent)) {
      boards.faults.reply = ReplyFault::kDrop;
      boards.faults.replies = -1;
    }
    if (begins(Kind::kAmplifier)) boards.board(0).faults.amp[0] = true;
    if (begins(Kind::kPower)) boards.chain.supply_on = false;
    for (int c = 0; c < kChannels; ++c) {
      if (begins(Kind::kEncoder)) boards.board(0).encoder(c).stuck = true;
      for (int b = 0; b < boards.boards() && begins(Kind::kStuck); ++b)
        boards.board(b).faults.stuck[c] = true;
    }
    if (begins(Kind::kJump))
      boards.board(sockets_[k].place).encoder(sockets_[k].channel).slip(slips_[k]);
  }
}

std::unique_ptr<DatagramLink> JoinedArms::link(int arm) {
  const std::uint16_t port = servers_[arm]->port();
  if (stepped_) return std::make_unique<SteppedLink>(port, *this);
  return std::make_unique<UdpLink>("127.0.0.1", port);
}

void JoinedArms::run(const std::atomic<bool>& stop) {
  const Clock::time_point begun = Clock::now();
  double reached = 0.0;
  while (!stop.load()) {
    const double now = std::chrono::duration<double>(Clock::now() - begun).count();
    if (now - reached > kMostBehind) reached = now - kMostBehind;
    for (; reached + kStep <= now; reached += kStep) advance(kStep);
    apply_faults();
    for (const auto& server : servers_) server->serve(5e-5);
  }
}

void JoinedArms::serve() {
  apply_faults();
  for (const auto& server : servers_)
    server->serve_waiting(static_cast<Ticks>(now_ * kTicksPerSecond));
}

void JoinedArms::pass(double seconds) {
  serve();
  for (const double until = now_ + std::max(0.0, seconds); now_ < until;) {
    now_ = std::min(until, reached_ + kStep);
    if (now_ < reached_ + kStep) break;
    serve();
    advance(kStep);
    reached_ += kStep;
  }
}

std::unique_ptr<JoinedBoards> emulate_boards(const Scenario& scenario, const std::vector<CooperatingArm>& arms,
                                             const BoardCooperationOptions& options) {
  return std::make_unique<JoinedArms>(scenario, arms, options);
}

}  // namespace veridyn::dvrk
