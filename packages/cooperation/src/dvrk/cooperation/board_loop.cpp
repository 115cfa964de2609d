#include "board_loop.hpp"

#include <algorithm>
#include <chrono>

#include "veridyn/dvrk/protocol/udp_link.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

constexpr double kLooking = 0.1;  // [s] duration of reading the boards before power-up
constexpr double kAfter = 0.02;   // [s] duration of reading the boards after power-off
constexpr double kJumpShare = 0.5;  // share of the largest force: a larger step between two readings is a sensor fault
constexpr double kLeastShare = 0.5;  // least share of the scenario's sensor rate; the message below says "half"
constexpr double kLeastPeriods = 3.0;       // shortest silence that counts as a dead sensor, in periods of the sensor
constexpr const char* kJumps = "jumps from one reading to the next by more than a force can";
constexpr double kAtRest = 0.05;  // share of the velocity limits, SafetyLimits::rest_share
constexpr double kExplained = 0.5;  // share of FaultChecks::force_disagreement below which a force counts as explained
constexpr const char* kNoTorque =
    "its torques do not explain the force that the other arms' torques do: motors without torque, a wrong encoder, or a contact elsewhere";
constexpr std::size_t kMostTold = 64;  // largest number of later faults that are reported

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
  watched_.resize(arms.size());
  later_.reserve(kMostTold);
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
  for (const ScenarioFault& fault : scenario_.faults) {
    if (fault.kind == ScenarioFault::Kind::kArmLimp)
      options_.faults.push_back({EmulatedFault::Kind::kLimp, *fault.arm, fault.at});
  }
  joined_ = options_.emulate(scenario_, arms, options_);
  if (options_.watch) joined_->watch(options_.watch);
  if (!options_.stepped) serving_ = std::thread([this] { joined_->run(stop_serving_); });
}

std::unique_ptr<DatagramLink> BoardLoop::link_to(const CooperatingArm& arm, std::size_t k) {
  if (joined_) return joined_->link(static_cast<int>(k));
  return std::make_unique<UdpLink>(arm.host, arm.port);
}

void BoardLoop::end_serving() {
  stop_serving_.store(true);
  if (serving_.joinable()) serving_.join();
}

bool BoardLoop::fail(const char* why, std::optional<int> arm, BoardEnd end) noexcept {
  if (why_ != nullptr) return false;
  why_ = why;
  faulty_arm_ = arm;
  end_ = end;
  fault_at_ = time_;
  return false;
}

bool BoardLoop::neighbours_explain_force(std::size_t k) const noexcept {
  const auto arm = static_cast<int>(k);
  bool any = false;
  for (const ScenarioMember& member : scenario_.members) {
    if (member.from != arm && member.to != arm) continue;
    const auto other = static_cast<std::size_t>(member.from == arm ? member.to : member.from);
    if (!(sides_[other]->unexplained_force() < kExplained * options_.checks.force_disagreement)) return false;
    any = true;
  }
  return any;
}

bool BoardLoop::collect_faults(std::size_t k) noexcept {
  bool found = false;
  for (;;) {
    BoardSide::News news = sides_[k]->poll_faults(scenario_.control.largest_age);
    if (news.what == nullptr) return found;
    found = true;
    // A wrong sensor contradicts the motors at both ends of its member, a limp arm only its own.
    if (news.unexplained && neighbours_explain_force(k)) news.what = kNoTorque;
    if (why_ == nullptr) {
      fail(news.what, static_cast<int>(k));
      faulty_joint_ = news.joint;
    } else if (!news.old_force && later_.size() < later_.capacity()) {  // old forces were reported
      later_.push_back({news.what, static_cast<int>(k), news.joint, time_});
    }
  }
}

void BoardLoop::watch_hold() noexcept {
  for (std::size_t k = 0; k < sides_.size() && why_ != nullptr; ++k) {
    Watched& arm = watched_[k];
    const BoardSide& side = *sides_[k];
    if (!arm.began) {
      arm.began = true;
      arm.from = side.tip();
      arm.at_fault = side.speed();
    }
    if (side.is_unresponsive()) arm.known = false;
    if (!side.valid()) continue;
    if (!arm.off && !side.powered()) arm.off = time_;
    if (gives_up_) continue;  // arms may move while the pretension is released
    arm.moved = std::max(arm.moved, (side.tip() - arm.from).norm());
    const bool rests = side.speed() <= kAtRest;
    if (rests && !arm.rest) arm.rest = time_ - fault_at_;
    if (!rests) arm.rest.reset();
  }
}

std::vector<ArmAfterFault> BoardLoop::after_fault() const {
  std::vector<ArmAfterFault> out;
  for (std::size_t k = 0; k < watched_.size() && why_ != nullptr; ++k) {
    const Watched& seen = watched_[k];
    if (!seen.began) continue;
    ArmAfterFault arm;
    arm.name = scenario_.arms[k].name;
    arm.known = seen.known;
    arm.moved = seen.moved;
    arm.rest_after = seen.rest;
    arm.off_at = seen.off;
    out.push_back(arm);
  }
  return out;
}

std::string BoardLoop::words(const char* what, int arm, std::optional<JointIndex> joint) const {
  const auto k = static_cast<size_t>(arm);
  const std::string where =
      joint ? " (joint " + sides_[k]->models().known.coordinates()[joint->value].name + ")" : "";
  return "arm " + scenario_.arms[k].name + ": " + what + where;
}

std::string BoardLoop::cause() const {
  if (why_ == nullptr) return "";
  if (faulty_sensor_ != nullptr) return "the force sensor " + faulty_sensor_->name + " " + why_;
  if (faulty_arm_) return words(why_, *faulty_arm_, faulty_joint_);
  return (end_ == BoardEnd::kStopped ? "" : "the controller ") + std::string(why_);
}

std::vector<LaterFault> BoardLoop::later_faults() const {
  std::vector<LaterFault> out;
  for (const Later& one : later_) out.push_back({one.at, words(one.what, one.arm, one.joint)});
  return out;
}

void BoardLoop::activate_fault() noexcept {
  for (const EmulatedFault& fault : options_.faults) {
    if (time_ >= fault.at) joined_->activate_fault(fault);
  }
}

std::vector<PlannedArm> BoardLoop::planned_arms() const {
  std::vector<PlannedArm> out;
  for (const auto& side : sides_)
    out.push_back({side->models().known, side->models().R_world_base_known,
                   side->models().p_world_base_known, side->largest_torque()});
  return out;
}

std::vector<VectorXd> BoardLoop::initial_state() const {
  std::vector<VectorXd> q;
  for (std::size_t k = 0; k < sides_.size(); ++k) {
    q.push_back(sides_[k]->session().state().q.head(sides_[k]->joints()));
    require(q[k].allFinite(), "arm '", scenario_.arms[k].name,
            "': found no position, expected its boards to answer.");
  }
  return q;
}

void BoardLoop::require_feasible(std::size_t p, double begins, const std::string& why) const {
  require(why.empty(), "scenario '", scenario_.name, "', phase '", scenario_.phases[p].name, "' (from ",
          begins, " s): ", why, ". Nothing was switched on.");
}

BoardLoop::Sensor BoardLoop::open_sensor(const std::string& source, const std::string& of, double rate,
                                         ForceChannelOptions options) const {
  options.largest_jump = kJumpShare * scenario_.control.largest_force;
  options.largest_silence = std::max(options.largest_silence, kLeastPeriods / rate);
  return {source + " of " + of, std::make_unique<ForceChannel>(options_.open_source(source), options), rate};
}

ForceReading BoardLoop::read_sensor(Sensor& sensor) noexcept {
  ForceReading reading = sensor.channel->update(now_);
  const bool jumps = sensor.channel->jumps() != sensor.jumps;
  sensor.jumps = sensor.channel->jumps();
  if (sensor.channel->state() == ForceState::kGood && !jumps) return reading;
  if (why_ == nullptr) {
    faulty_sensor_ = &sensor;
    fail(jumps ? kJumps : describe(sensor.channel->state()), {});
  }
  reading.age = kNever;
  return reading;
}

void BoardLoop::wait_for_sensors(std::vector<Sensor>& sensors) {
  const std::size_t count = sensors.size();
  std::vector<double> good_since(count, -1.0);
  std::vector<long> before(count, 0), readings(count, 0);  // number of readings at good_since, and since then
  std::vector<long> numbers(count, 0);
  std::vector<double> last(count, -1.0);  // [s] time of the last reading
  const double begun = time_;
  const auto heard = [&](std::size_t k) { return good_since[k] >= 0.0 && now_ - good_since[k] >= kHeard; };
  for (const double until = time_ + options_.sensor_patience; !stopped();) {
    cycle([&] {
      for (std::size_t k = 0; k < count; ++k) {
        Sensor& sensor = sensors[k];
        const long number = sensor.channel->update(now_).number.value_or(0);
        const bool good = sensor.channel->state() == ForceState::kGood && sensor.channel->jumps() == sensor.jumps;
        sensor.jumps = sensor.channel->jumps();
        if (!good || good_since[k] < 0.0) {
          good_since[k] = good ? now_ : -1.0;
          before[k] = number;
        }
        readings[k] = number - before[k];
        if (number != numbers[k]) last[k] = now_;
        numbers[k] = number;
      }
    });
    std::size_t k = 0;
    while (k < count && heard(k)) ++k;
    if (k == count) {
      for (k = 0; k < count; ++k) {
        const double rate = static_cast<double>(readings[k]) / (now_ - good_since[k]);
        require(rate >= kLeastShare * sensors[k].rate, "no power: the force sensor ", sensors[k].name, " gives ",
                std::round(rate), " readings per second; the scenario counts on ", sensors[k].rate,
                " (sensor: rate), expected half of them or more.");
      }
      return;
    }
    const ForceChannel& silent = *sensors[k].channel;
    const bool comes = last[k] >= 0.0 && now_ - last[k] < kHeard;
    const bool gaps = silent.state() == ForceState::kGood || (silent.state() == ForceState::kDead && comes);
    require(time_ < until, "no power: the force sensor ", sensors[k].name, " ",
            gaps ? "does not stay good" : describe(silent.state()), " (",
            silent.source().rejected_readings() + silent.beyond_range() + silent.jumps(),
            " lines refused, ", std::round(static_cast<double>(numbers[k]) / (time_ - begun)),
            " readings per second where the scenario counts on ", sensors[k].rate, "); expected good readings for ",
            kHeard, " s within ", options_.sensor_patience, " s.");
    // Lines use the machine's time, also with a stepped clock.
    if (options_.stepped) std::this_thread::sleep_for(std::chrono::duration<double>(period_));
  }
}

void BoardLoop::read_before_power() {
  repeat(kLooking, [] {});
}

bool BoardLoop::power_up(std::vector<Sensor>& sensors) {
  for (size_t k = 0; k < sides_.size(); ++k) {
    if (const char* refused = sides_[k]->session().power_on())
      return fail(refused, static_cast<int>(k));
  }
  for (size_t k = 0; k < sides_.size(); ++k) sides_[k]->begin(scenario_, k);
  const double until = time_ + options_.power_timeout;
  while (time_ < until) {
    cycle([&] {
      for (Sensor& sensor : sensors) {
        sensor.channel->update(now_);
        sensor.jumps = sensor.channel->jumps();
      }
      for (auto& side : sides_) {  // initial positions, before the scenario begins
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
  not_off_.clear();
  for (std::size_t k = 0; k < sides_.size(); ++k) {
    const OffState one = sides_[k]->session().boards().shutdown();
    if (one != OffState::kConfirmed)
      not_off_ += (not_off_.empty() ? "arm " : ", arm ") + scenario_.arms[k].name;
    worst = std::max(worst, one);
  }
  return worst;
}

}  // namespace veridyn::dvrk
