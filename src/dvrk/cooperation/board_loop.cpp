#include "board_loop.hpp"

#include <chrono>

#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

constexpr double kLooking = 0.1;  // [s] of reading before power is asked for
constexpr double kAfter = 0.02;   // [s] of reading after power went
constexpr double kJumpShare = 0.5;  // of the largest force: more between two readings is no force

}  // namespace

BoardLoop::BoardLoop(const Scenario& scenario, const std::vector<CooperatingArm>& arms,
                     const BoardCooperationOptions& options, const std::atomic<bool>& stop)
    : scenario_(scenario),
      options_(options),
      period_(1.0 / scenario.control.rate),
      stop_(stop) {
  require(arms.size() == scenario_.arms.size(), "boards: found configurations of ", arms.size(),
          " arms, expected one for each of the scenario's ", scenario_.arms.size(), ".");
  require(options_.emulate || (!options_.stepped && options_.faults.empty()),
          "boards: found a stepped clock or faults, expected them of emulated boards alone.");
  if (options.emulate) join(arms);
  try {
    for (size_t k = 0; k < arms.size(); ++k)
      sides_.push_back(
          std::make_unique<BoardSide>(scenario, k, arms[k], options, link_to(arms[k], k)));
  } catch (...) {
    end_serving();
    throw;
  }
}

void BoardLoop::join(const std::vector<CooperatingArm>& arms) {
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

std::unique_ptr<DatagramLink> BoardLoop::link_to(const CooperatingArm& arm, std::size_t k) {
  if (!joined_) return std::make_unique<UdpLink>(arm.host, arm.port);
  const std::uint16_t port = joined_->port(static_cast<int>(k));
  if (options_.stepped) return std::make_unique<SteppedLink>(port, *joined_);
  return std::make_unique<UdpLink>("127.0.0.1", port);
}

void BoardLoop::end_serving() {
  stop_serving_.store(true);
  if (serving_.joinable()) serving_.join();
}

bool BoardLoop::fail(const char* why, int arm, BoardEnd end) noexcept {
  if (why_ != nullptr) return false;
  why_ = why;
  faulty_arm_ = arm;
  end_ = end;
  fault_at_ = time_;
  return false;
}

std::string BoardLoop::cause() const {
  if (why_ == nullptr) return "";
  if (faulty_arm_ >= 0) {
    const auto k = static_cast<size_t>(faulty_arm_);
    const SafetySupervisor* safety = sides_[k]->supervisor();
    const int joint = safety != nullptr ? safety->joint() : -1;
    const std::string where =
        joint >= 0 ? " (joint " + sides_[k]->models().known.coordinates()[static_cast<size_t>(joint)].name + ")" : "";
    return "arm " + scenario_.arms[k].name + ": " + why_ + where;
  }
  return (end_ == BoardEnd::kStopped ? "" : "the controller ") + std::string(why_);
}

void BoardLoop::break_down() noexcept {
  for (const EmulatedFault& fault : options_.faults) {
    if (time_ >= fault.at) joined_->break_down(fault);
  }
}

BoardLoop::Sensor BoardLoop::open_sensor(const std::string& source, const std::string& of,
                                         ForceChannelOptions options) const {
  options.largest_jump = kJumpShare * scenario_.control.largest_force;
  return {source + " of " + of, std::make_unique<ForceChannel>(options_.open_source(source), options)};
}

void BoardLoop::hear(const std::vector<Sensor>& sensors) {
  const std::size_t count = sensors.size();
  std::vector<double> good_since(count, -1.0);
  const auto heard = [&](std::size_t k) { return good_since[k] >= 0.0 && now_ - good_since[k] >= kHeard; };
  for (const double until = time_ + options_.sensor_patience; !stopped();) {
    cycle([&] {
      for (std::size_t k = 0; k < count; ++k) {
        sensors[k].channel->update(now_);
        const bool good = sensors[k].channel->state() == ForceState::kGood;
        if (!good || good_since[k] < 0.0) good_since[k] = good ? now_ : -1.0;
      }
    });
    std::size_t k = 0;
    while (k < count && heard(k)) ++k;
    if (k == count) return;
    const ForceChannel& silent = *sensors[k].channel;
    require(time_ < until, "no power: the force sensor ", sensors[k].name, " ",
            silent.state() == ForceState::kGood ? "does not stay good" : describe(silent.state()), " (",
            silent.source().refused() + silent.beyond_range() + silent.jumps(),
            " lines refused); expected good readings for ", kHeard, " s within ",
            options_.sensor_patience, " s.");
    // Lines keep the machine's time, whatever the boards' clock does.
    if (options_.stepped) std::this_thread::sleep_for(std::chrono::duration<double>(period_));
  }
}

bool BoardLoop::power_up() {
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
        side->act(TipTarget{}, Eigen::Vector3d::Zero(), 0.0, dt_);
      }
    });
    if (std::all_of(sides_.begin(), sides_.end(),
                    [](const auto& side) { return side->session().ready(); })) {
      timing_ = {};
      time_ = 0.0;
      return true;
    }
  }
  for (size_t k = 0; k < sides_.size(); ++k) {
    if (!sides_[k]->session().ready())
      return fail("its power does not come up", static_cast<int>(k));
  }
  return false;
}

OffState BoardLoop::power_down() {
  for (auto& side : sides_) side->session().power_off();
  repeat(kAfter, [] {});
  OffState worst = OffState::kConfirmed;
  for (auto& side : sides_) worst = std::max(worst, side->session().boards().shutdown());
  return worst;
}

}  // namespace veridyn::dvrk
