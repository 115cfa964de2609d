#include "dvrk/run/arm_session.hpp"

#include <algorithm>
#include <cmath>

#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

// Time between two readings of the pots if no rate is given, short enough for the watchdog.
constexpr double kPotPeriod = 0.001;  // [s] time between two readings

// Connector of a board's axis; `boards` are ascending ids that contain `board`.
Socket socket(const std::vector<int>& boards, int board, int axis) {
  const auto place = std::lower_bound(boards.begin(), boards.end(), board) - boards.begin();
  return {static_cast<int>(place), axis};
}

// Throws InvalidInput if no supported board has this axis.
void require_channel(const RobotConfig& robot, int board, int axis) {
  require(axis < kChannels, "robot '", robot.name, "': found board ", board, " axis ", axis,
          ", expected axes 0 to ", kChannels - 1, ".");
}

// Zero and largest current of a channel in bits.
void set_current_limits(const LinearScale& amps_to_bits, const LinearScale& bits_to_amps,
                   double max_current, ChannelSafety& safety) {
  safety.used = true;
  safety.zero_command = nearest_word(amps_to_bits.offset, kZeroCurrent);
  safety.zero_feedback = bits_to_amps.inverse(0.0);
  safety.feedback_per_command = 1.0 / (amps_to_bits.scale * bits_to_amps.scale);
  // Half a bit for rounding: the largest current itself is allowed.
  safety.max_current = std::abs(amps_to_bits.scale) * max_current + 0.5;
}

// False if pots sit on joints or need a lookup table: they cannot be compared with encoders then.
bool pots_on_actuators(const RobotConfig& robot) {
  return robot.pot_lookup_table.empty() &&
         (robot.pots_to_actuators.size() == 0 || robot.pots_to_actuators.isIdentity(1e-12));
}

}  // namespace

std::vector<int> boards_of(const RobotConfig& robot) {
  std::vector<int> boards;
  const auto add = [&](int board, int axis) {
    require_channel(robot, board, axis);
    boards.push_back(board);
  };
  for (const ActuatorConfig& actuator : robot.actuators) {
    add(actuator.board, actuator.axis);
    if (actuator.brake) add(actuator.brake->board, actuator.brake->axis);
  }
  std::sort(boards.begin(), boards.end());
  boards.erase(std::unique(boards.begin(), boards.end()), boards.end());
  return boards;
}

std::vector<Socket> sockets_of(const RobotConfig& robot) {
  const std::vector<int> boards = boards_of(robot);
  std::vector<Socket> sockets;
  for (const ActuatorConfig& actuator : robot.actuators)
    sockets.push_back(socket(boards, actuator.board, actuator.axis));
  return sockets;
}

SessionOptions session_options(const RobotConfig& robot, const ArmSessionOptions& how) {
  require(robot.hardware == "QLA1", "robot '", robot.name, "': found hardware ", robot.hardware,
          ", expected QLA1: other boards cannot be driven.");
  require(how.rate >= 0.0, "robot '", robot.name, "': found a rate of ", how.rate,
          " Hz, expected 0 or more.");
  SessionOptions options;
  options.bus.protocol = how.protocol;
  options.bus.mtu = how.mtu;
  options.bus.access = how.access;
  options.bus.announce = how.announce;
  options.bus.firewire = how.firewire;
  options.watchdog = how.watchdog;
  options.bus.reply_timeout = how.reply_timeout;
  options.bus.repeat_after = how.repeat_after;
  options.follow = how.follow;
  options.stall = how.stall;
  // A longer watchdog allows more lost reads in a row.
  const double reply = std::max(how.reply_timeout, BusOptions().reply_timeout);
  options.lost_reads = std::max(options.lost_reads, static_cast<int>(how.watchdog / reply));
  options.bus.cycle_time = how.rate > 0.0 ? 1.0 / how.rate : 0.0;
  options.bus.boards = boards_of(robot);
  options.channels.assign(options.bus.boards.size(), {});
  const std::vector<Socket> sockets = sockets_of(robot);
  for (std::size_t k = 0; k < sockets.size(); ++k) {
    const ActuatorConfig& actuator = robot.actuators[k];
    ChannelSafety& safety = options.channels[sockets[k].place]
                                            [sockets[k].channel];
    set_current_limits(actuator.amps_to_bits, actuator.bits_to_amps, actuator.max_current, safety);
    safety.rest_counts = std::max(
        1.0, how.standstill * (actuator.upper - actuator.lower) / std::abs(actuator.bits_to_position));
    safety.counts_to_position = {actuator.bits_to_position, 0.0};
    const LinearScale& volts = actuator.bits_to_volts;
    const LinearScale& position = actuator.volts_to_position;
    safety.pot_to_position = {position.scale * volts.scale, position(volts.offset)};
    if (k < robot.pot_tolerances.size() && pots_on_actuators(robot)) {
      safety.pot_tolerance = robot.pot_tolerances[k].distance;
      safety.pot_latency = robot.pot_tolerances[k].latency;
      safety.watch_pot_rail = safety.pot_tolerance > 0.0;
    }
    if (!actuator.brake) continue;
    const BrakeConfig& brake = *actuator.brake;
    const Socket at = socket(options.bus.boards, brake.board, brake.axis);
    set_current_limits(
        brake.amps_to_bits, brake.bits_to_amps, brake.max_current,
        options.channels[at.place][at.channel]);
  }
  return options;
}

ArmSession::ArmSession(DatagramLink& link, const RobotConfig& robot,
                       const ArmSessionOptions& options)
    : link_(link),
      options_(options),
      units_(robot, options.actuator_to_joint),
      boards_(link, session_options(robot, options)),
      sockets_(sockets_of(robot)),
      raw_(robot.actuators.size()),
      state_(robot.size()),
      command_(robot.size()) {
  require(options.pot_readings > 0, "robot '", robot.name, "': found ", options.pot_readings,
          " pot readings, expected at least one.");
  for (const ActuatorConfig& actuator : robot.actuators) {
    if (!actuator.brake) continue;
    brakes_.emplace_back(*actuator.brake);
    brake_sockets_.push_back(socket(boards_of(robot), actuator.brake->board, actuator.brake->axis));
  }
}

void ArmSession::start() {
  boards_.start();
  units_.reset();
  homing_ = {};
  require_velocities();
  if (!boards_.listens()) require_own_boards();
  // Encoders that cannot be loaded keep their counts.
  homed_ = !robot().has_encoder_preload || !needs_homing();
  if (homed_ || options_.homing == Homing::kNever || boards_.listens()) return;
  home();
  require(homing_.done, "robot '", robot().name,
          "': the encoders cannot be loaded: ", homing_.reason, ".");
}

void ArmSession::require_velocities() const {
  for (std::size_t k = 0; k < sockets_.size(); ++k) {
    const int firmware = boards_.bus().info(sockets_[k].place).firmware;
    const bool own = robot().actuators[k].velocity_source == VelocitySource::kSoftware;
    require(own || firmware >= 7, "robot '", robot().name, "': actuator ", k, ": found firmware ",
            firmware,
            ", whose velocities have another form, expected 7 or more, or VelocitySource ",
            "SOFTWARE.");
  }
}

// Ids are set by switches; serial numbers cannot be changed.
void ArmSession::require_own_boards() {
  const std::vector<int> ids = boards_of(robot());
  for (const BoardSerial& own : robot().board_serials) {
    const auto at = std::find(ids.begin(), ids.end(), own.board);
    if (at == ids.end()) continue;
    const std::string found = boards_.bus().qla_serial(static_cast<int>(at - ids.begin()));
    require(found == own.serial, "robot '", robot().name, "'",
            robot().serial.empty() ? "" : " (SN " + robot().serial + ")", ": found a board ", own.board,
            found.empty() ? std::string(" without a serial number") : " with the serial number " + found,
            ", expected ", own.serial, ": this is another arm, or a board was exchanged.");
  }
}

bool ArmSession::needs_homing() noexcept {
  for (const Socket& s : sockets_)
    if (boards_.needs_preload(s.place, s.channel)) return true;
  return false;
}

void ArmSession::read_raw() noexcept {
  for (std::size_t k = 0; k < raw_.size(); ++k) {
    const BoardFeedback& board = boards_.bus().feedback(sockets_[k].place);
    const ChannelFeedback& channel = board.channel[sockets_[k].channel];
    raw_[k] = {channel.encoder, channel.pot, channel.current, board.seconds()};
  }
}

bool ArmSession::update() noexcept {
  commanded_ = false;
  if (!boards_.update()) return false;
  read_raw();
  units_.read(raw_.data(), state_);
  return true;
}

void ArmSession::set_torques(const VectorRef& tau) noexcept {
  units_.write(tau, command_);
  commanded_ = command_.valid;
}

const BoardFeedback& ArmSession::board_of(int actuator) const {
  return boards_.bus().feedback(sockets_[actuator].place);
}

bool ArmSession::ready() const {
  return boards_.state() == PowerState::kOn &&
         std::all_of(brakes_.begin(), brakes_.end(),
                     [](const BrakeDriver& brake) { return brake.released(); });
}

void ArmSession::command_brakes() noexcept {
  const bool on = boards_.state() == PowerState::kOn;
  for (std::size_t k = 0; k < brakes_.size(); ++k) {
    const auto wish = on ? BrakeDriver::Wish::kReleased : BrakeDriver::Wish::kEngaged;
    const double current = brakes_[k].current(wish, link_.now());
    boards_.set_command(brake_sockets_[k].place, brake_sockets_[k].channel,
                        brakes_[k].config().amps_to_bits(current));
  }
}

void ArmSession::commit() noexcept {
  command_brakes();
  if (commanded_ && ready()) {
    for (std::size_t k = 0; k < sockets_.size(); ++k)
      boards_.set_command(sockets_[k].place, sockets_[k].channel, command_.bits[k]);
  }
  commanded_ = false;
  boards_.commit();
}

const char* ArmSession::power_on() noexcept {
  if (!homed_) return "the encoders were never loaded: home first";
  if (!homing_.outside_limits.empty())
    return "an actuator stands outside its soft limits by its pot: move it inside, home again";
  return boards_.power_on();
}

// @returns the reason for a failure; empty after success.
std::string ArmSession::average_pots(VectorXd& mean) {
  VectorXd low = VectorXd::Constant(joints(), 65535.0);
  VectorXd high = VectorXd::Zero(joints());
  mean.setZero(joints());
  int readings = 0;
  for (int trial = 0; trial < 2 * options_.pot_readings && readings < options_.pot_readings;
       ++trial) {
    if (boards_.update()) {
      read_raw();
      ++readings;
      for (int i = 0; i < joints(); ++i) {
        const double pot = raw_[i].pot;
        mean[i] += (pot - mean[i]) / readings;
        low[i] = std::min(low[i], pot);
        high[i] = std::max(high[i], pot);
      }
    }
    boards_.commit();
    link_.wait(options_.rate > 0.0 ? 1.0 / options_.rate : kPotPeriod);
  }
  if (readings < options_.pot_readings)
    return text("only ", readings, " of ", options_.pot_readings, " reads were valid");
  for (int i = 0; i < joints(); ++i) {
    const ActuatorConfig& actuator = units_.robot().actuators[i];
    if (at_rail(mean[i]))
      return text("the pot of actuator ", i, " reads ", actuator.bits_to_volts(mean[i]),
                  " V, an end of its range: the arm stands outside, or a wire is gone");
    const double way = std::abs(actuator.volts_to_position.scale * actuator.bits_to_volts.scale) *
                       (high[i] - low[i]);
    if (way <= options_.pot_unrest * (actuator.upper - actuator.lower)) continue;
    return text("the pot of actuator ", i, " moved by ", way, actuator.prismatic ? " m" : " rad",
                " while it should rest");
  }
  return "";
}

std::string ArmSession::load_encoders(const VectorRef& actuator_q) {
  std::vector<std::uint32_t> words(sockets_.size());
  units_.preload_words(actuator_q, words.data());
  for (std::size_t k = 0; k < sockets_.size(); ++k) {
    const double counts =
        actuator_q[static_cast<Eigen::Index>(k)] / robot().actuators[k].bits_to_position;
    if (!(std::abs(counts) < kEncoderZero - 1.0))
      return text("actuator ", k, " stands at ", counts, " counts, more than 24 bits");
    // A counter of zero would look uninitialised to the next client: one count instead.
    const std::int32_t loaded = encoder_counts(words[k]) == 0 ? 1 : encoder_counts(words[k]);
    if (!boards_.preload(sockets_[k].place, sockets_[k].channel, loaded))
      return text("the encoder of actuator ", k, " does not take its preload");
  }
  return "";
}

std::string ArmSession::load_from_pots() {
  if (boards_.listens()) return "this session reads alone";
  if (!robot().has_encoder_preload) return "the configuration has no encoder preload";
  if (!robot().pot_lookup_table.empty())
    return "the pots need the lookup table " + robot().pot_lookup_table;
  const PowerState power = boards_.state();
  if (power != PowerState::kOff && power != PowerState::kFault) return "power is on";
  homed_ = false;
  VectorXd mean(joints());
  const std::string unrest = average_pots(mean);
  if (!unrest.empty()) return unrest;
  homing_.actuator_q = VectorXd::Zero(joints());
  units_.pot_positions(mean, homing_.actuator_q);
  return load_encoders(homing_.actuator_q);
}

const HomingReport& ArmSession::home() {
  homing_ = {};
  homing_.reason = load_from_pots();
  if (!homing_.reason.empty()) return homing_;
  units_.reset();
  for (int i = 0; i < joints(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double slack =
        k < robot().pot_tolerances.size() ? robot().pot_tolerances[k].distance : 0.0;
    const double q = homing_.actuator_q[i];
    if (q < robot().actuators[k].lower - slack || q > robot().actuators[k].upper + slack)
      homing_.outside_limits.push_back(i);
  }
  homing_.done = homed_ = true;
  return homing_;
}

namespace {

// @returns false: no board answers a client that has not announced itself, as after the boards' power-up.
bool confirms_power_off(DatagramLink& link, const RobotConfig& robot, const ArmSessionOptions& options) {
  ArmSession look(link, robot, options);
  try {
    look.start();
  } catch (const InvalidInput&) {
    if (options.announce) throw;
    return false;
  }
  require(look.update(), "boards: not a single valid read.");
  const BoardBus& bus = look.boards().bus();
  for (int b = 0; b < bus.boards(); ++b)
    require(!bus.feedback(b).status.power_requested(), "--home: board ", bus.info(b).id,
            " has motor power: another program drives it.");
  return true;
}

}  // namespace

void require_no_power(DatagramLink& link, const RobotConfig& robot, ArmSessionOptions options) {
  options.access = Access::kListen;
  options.homing = Homing::kNever;
  options.announce = false;
  if (confirms_power_off(link, robot, options)) return;
  options.announce = true;
  confirms_power_off(link, robot, options);
}

}  // namespace veridyn::dvrk
