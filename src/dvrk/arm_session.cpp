#include "veridyn/dvrk/arm_session.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

std::vector<int> boards_of(const RobotConfig& robot) {
  std::set<int> ids;
  for (const ActuatorConfig& actuator : robot.actuators) ids.insert(actuator.board);
  return {ids.begin(), ids.end()};
}

// second(first(x)) of two linear scales.
LinearScale chained(const LinearScale& first, const LinearScale& second) {
  return {second.scale * first.scale, second.offset + second.scale * first.offset};
}

ChannelSafety safety_of(const ActuatorConfig& actuator) {
  ChannelSafety s;
  s.used = true;
  s.zero_command = nearest_word(actuator.amps_to_bits(0.0), kZeroCurrent);
  s.zero_feedback = actuator.bits_to_amps.inverse(0.0);
  s.max_current = std::abs(actuator.amps_to_bits.scale) * actuator.max_current;
  s.counts_to_position = {actuator.bits_to_position, 0.0};
  s.pot_to_position = chained(actuator.bits_to_volts, actuator.volts_to_position);
  return s;
}

}  // namespace

SessionOptions session_options(const RobotConfig& robot, const ArmSessionOptions& options) {
  require(robot.hardware == "QLA1", "arm '", robot.name, "': found hardware ", robot.hardware,
          ", expected QLA1.");
  SessionOptions session;
  session.bus.boards = boards_of(robot);
  session.bus.protocol = options.protocol;
  session.bus.cycle_time = options.rate > 0.0 ? 1.0 / options.rate : 0.0;
  session.bus.mtu = options.mtu;
  session.watchdog = options.watchdog;
  session.channels.resize(session.bus.boards.size());
  for (int i = 0; i < robot.size(); ++i) {
    const ActuatorConfig& actuator = robot.actuators[static_cast<size_t>(i)];
    require(actuator.axis >= 0 && actuator.axis < kChannels, "arm '", robot.name, "': actuator ", i,
            ": found axis ", actuator.axis, ", expected 0 to 3.");
    const auto place =
        std::find(session.bus.boards.begin(), session.bus.boards.end(), actuator.board);
    ChannelSafety& channel =
        session.channels[static_cast<size_t>(place - session.bus.boards.begin())]
                        [static_cast<size_t>(actuator.axis)];
    channel = safety_of(actuator);
    for (const PotTolerance& tolerance : robot.pot_tolerances) {
      if (tolerance.axis != i || robot.pots_to_actuators.size() > 0) continue;
      channel.pot_tolerance = tolerance.distance;
      channel.pot_latency = tolerance.latency;
    }
  }
  return session;
}

ArmSession::ArmSession(DatagramLink& link, const RobotConfig& robot,
                       const ArmSessionOptions& options)
    : link_(link),
      options_(options),
      units_(robot, options.actuator_to_joint),
      boards_(link, session_options(robot, options)),
      raw_(robot.actuators.size()),
      state_(robot.size()),
      command_(robot.size()) {
  const std::vector<int> ids = boards_of(robot);
  for (const ActuatorConfig& actuator : robot.actuators) {
    const auto at = std::find(ids.begin(), ids.end(), actuator.board);
    places_.push_back(static_cast<int>(at - ids.begin()));
  }
}

void ArmSession::start() {
  boards_.start();
  preloaded_ = false;
  units_.reset();
  for (int i = 0; i < size(); ++i) {
    const bool from_firmware =
        robot().actuators[static_cast<size_t>(i)].velocity_source == VelocitySource::kFirmware;
    const int firmware = boards_.bus().info(place(i)).firmware;
    require(firmware >= 7 || !from_firmware, "arm '", robot().name, "': found firmware ", firmware,
            ", whose velocities have another form; set VelocitySource to SOFTWARE.");
  }
  bool needed = false;
  for (int i = 0; i < size(); ++i)
    needed =
        needed || boards_.needs_preload(place(i), robot().actuators[static_cast<size_t>(i)].axis);
  if (needed && robot().has_encoder_preload) preload_from_pots();
}

// Section 14.5 #2.
void ArmSession::preload_from_pots() {
  VectorXd bits = VectorXd::Zero(size());
  int taken = 0;
  for (int k = 0; k < 5 * options_.pot_readings && taken < options_.pot_readings; ++k) {
    if (update()) {
      for (int i = 0; i < size(); ++i) bits[i] += raw_[static_cast<size_t>(i)].pot;
      ++taken;
    }
    commit();
    link_.wait(0.001);
  }
  require(taken == options_.pot_readings, "arm '", robot().name, "': its pots cannot be read.");
  bits /= taken;
  VectorXd q = VectorXd::Zero(size());
  units_.pot_positions(bits, q);
  std::vector<std::uint32_t> words(static_cast<size_t>(size()));
  units_.preload_words(q, words.data());
  for (int i = 0; i < size(); ++i) {
    const int axis = robot().actuators[static_cast<size_t>(i)].axis;
    require(boards_.preload(place(i), axis, encoder_counts(words[static_cast<size_t>(i)])), "arm '",
            robot().name, "': the encoder of actuator ", i,
            " does not take its preload, or its overflow bit stays.");
  }
  units_.reset();
  preloaded_ = true;
}

const BoardFeedback& ArmSession::board_of(int actuator) const {
  return boards_.bus().feedback(place(actuator));
}

bool ArmSession::update() noexcept {
  if (!boards_.update()) return false;
  for (int i = 0; i < size(); ++i) {
    const auto k = static_cast<size_t>(i);
    const BoardFeedback& board = board_of(i);
    const ChannelFeedback& channel = board.channel[static_cast<size_t>(robot().actuators[k].axis)];
    raw_[k] = {channel.encoder, channel.pot, channel.current, board.seconds()};
  }
  units_.read(raw_.data(), state_);
  return true;
}

void ArmSession::set_torques(const VectorXd& tau) noexcept {
  units_.write(tau, command_);
  for (int i = 0; i < size(); ++i) {
    const auto k = static_cast<size_t>(i);
    boards_.set_command(place(i), robot().actuators[k].axis, command_.bits[k]);
  }
}

}  // namespace veridyn::dvrk
