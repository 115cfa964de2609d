#include "joined_arms.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "dvrk/run/arm_session.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kStep = 5e-4;         // [s] of the world between two looks at the sockets
constexpr double kMostBehind = 0.02;   // [s] that are made up for after a pause of the machine
constexpr double kBrake = 2.0 * M_PI * 20.0;  // [rad/s] of brakes that hold an arm

std::vector<BoardSetup> setups(const RobotConfig& robot, int firmware) {
  std::vector<BoardSetup> out;
  for (const int id : boards_of(robot)) {
    BoardSetup setup;
    setup.id = id;
    setup.firmware = firmware;
    out.push_back(setup);
  }
  return out;
}

}  // namespace

JoinedArms::JoinedArms(const Scenario& scenario, const std::vector<RobotConfig>& robots,
                       const std::vector<MatrixXd>& couplings, int firmware)
    : experiment_(scenario, "veridyn"),
      tension_(scenario.members.size()),
      silent_(scenario.arms.size()),
      broken_(scenario.arms.size()) {
  require(robots.size() == scenario.arms.size() && couplings.size() == robots.size(),
          "emulated boards: found ", robots.size(), " configurations, expected one for each of ",
          scenario.arms.size(), " arms.");
  for (size_t k = 0; k < robots.size(); ++k) {
    const ScenarioArm& arm = scenario.arms[k];
    states_.emplace_back(experiment_.real(static_cast<int>(k)), Tip{arm.frame, arm.offset});
    brakes_.push_back(arm.start);
    tau_.push_back(VectorXd::Zero(arm.start.size()));
    joints_.push_back(std::make_unique<Joint>(experiment_.world(), static_cast<int>(k)));
    emulators_.push_back(std::make_unique<BoardEmulator>(setups(robots[k], firmware)));
    loads_.push_back(std::make_unique<SimulatedArm>(*joints_[k], robots[k], couplings[k],
                                                    boards_of(robots[k]), arm.start));
    servers_.push_back(std::make_unique<BoardServer>(*emulators_[k], 0));
    emulators_[k]->attach(loads_[k].get());
  }
}

void JoinedArms::advance(double seconds) {
  World& world = experiment_.world();
  for (size_t k = 0; k < joints_.size(); ++k) {
    const VectorXd& q = world.q(static_cast<int>(k));
    if (joints_[k]->driven()) {
      tau_[k] = joints_[k]->tau();
      brakes_[k] = q;
      continue;
    }
    const VectorXd& dq = world.dq(static_cast<int>(k));
    states_[k].update(q, dq);
    tau_[k] = states_[k].bias() + states_[k].mass_matrix() *
                                      (kBrake * kBrake * (brakes_[k] - q) - 2.0 * kBrake * dq);
  }
  world.step(tau_, seconds);
  for (size_t k = 0; k < tension_.size(); ++k) {
    const double tension = world.member(static_cast<int>(k)).tension;
    tension_[k].store(tension);
    largest_force_.store(std::max(largest_force_.load(), std::abs(tension)));
  }
}

void JoinedArms::run(const std::atomic<bool>& stop) {
  const Clock::time_point begun = Clock::now();
  double reached = 0.0;
  while (!stop.load()) {
    for (size_t k = 0; k < servers_.size(); ++k) {
      if (silent_[k].load()) {
        emulators_[k]->faults.reply = ReplyFault::kDrop;
        emulators_[k]->faults.replies = -1;
      }
      if (broken_[k].load()) emulators_[k]->board(0).faults.amp[0] = true;
      servers_[k]->serve(5e-5);
    }
    const double now = std::chrono::duration<double>(Clock::now() - begun).count();
    if (now - reached > kMostBehind) reached = now - kMostBehind;
    for (; reached + kStep <= now; reached += kStep) advance(kStep);
  }
}

}  // namespace veridyn::dvrk
