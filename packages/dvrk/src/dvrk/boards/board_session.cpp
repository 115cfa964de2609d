#include "dvrk/boards/board_session.hpp"

#include <algorithm>
#include <cmath>

#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

constexpr int kAmpsFirst = 2;  // cycles with amplifiers off before the supply is switched off
constexpr double kObeyBlocks = 0.005;     // [s] within which blocks must show "off"; otherwise registers are written
constexpr double kObeyRegisters = 0.020;  // [s] in which boards must obey; afterwards this program is silent, so that the watchdog switches off
constexpr double kBlind = 0.1;  // [s] time after which boards that do not answer are left to their watchdog, once
constexpr double kBite = 2.0;   // duration of that silence, in watchdog periods

}  // namespace

const char* describe(PowerState state) {
  switch (state) {
    case PowerState::kOff:
      return "off";
    case PowerState::kRelay:
      return "closing the safety relay";
    case PowerState::kPower:
      return "waiting for the motor supply";
    case PowerState::kAmps:
      return "enabling the amplifiers";
    case PowerState::kOn:
      return "on";
    case PowerState::kFault:
      return "fault";
  }
  return "";
}

BoardSession::BoardSession(DatagramLink& link, const SessionOptions& options)
    : link_(link), options_(options), bus_(link, options.bus), channels_(options.channels) {
  require(options.watchdog > 0.0 && options.watchdog <= 0.34, "boards: found a watchdog of ",
          options.watchdog, " s, expected more than 0 and at most 0.34.");
  for (const double seconds : {options.relay_timeout, options.supply_timeout, options.off_timeout})
    require(std::isfinite(seconds) && seconds > 0.0, "boards: found a timeout of ", seconds, " s, expected a number above zero.");
  channels_.resize(bus_.boards());
  states_.resize(channels_.size());
  for (int b = 0; b < bus_.boards(); ++b) {
    for (int c = 0; c < kChannels; ++c) {
      const ChannelSafety& s = safety(b, c);
      require(!s.used || s.max_current > 0.0, "boards: board ", bus_.info(b).id, " channel ", c + 1,
              ": found a largest current of ", s.max_current, " bits, expected a positive one.");
      bus_.set_zero(b, c, s.zero_command);
    }
  }
}

BoardSession::~BoardSession() {
  shutdown();
}

void BoardSession::enter(PowerState state) noexcept {
  state_ = state;
  entered_ = link_.now();
  off_cycles_ = 0;
  for (auto& board : states_) {
    for (ChannelState& c : board) c.amp_missing_since.reset();
  }
}

void BoardSession::start() {
  enter(PowerState::kOff);
  power_off_asked_ = true;
  all_valid_ = false;
  bus_.start();
  started_ = true;
  if (listens()) return;
  bus_.switch_off(BoardBus::Off::kPower);
  require(bus_.set_watchdog(options_.watchdog),
          "boards: a watchdog does not take the period that it was given.");
}

// Of two reactions the stronger one is kept. Only acknowledge() leaves kFault.
void BoardSession::escalate(Reaction reaction, Condition condition, std::optional<int> board,
                         std::optional<int> channel) noexcept {
  if (reaction == Reaction::kReport) return;
  if (reaction == Reaction::kPowerOff) power_off_asked_ = true;
  if (!is_powering_up()) return;
  if (reaction == Reaction::kAmpsOff) power_off_asked_ = false;
  cause_ = condition;
  cause_board_ = board;
  cause_channel_ = channel;
  enter(PowerState::kFault);
  if (reaction == Reaction::kPowerOff) off_cycles_ = kAmpsFirst;  // skips the cycles of a normal power-down
}

std::string BoardSession::cause_text() const {
  std::string out = describe(cause_);
  if (cause_ == Condition::kLostReplies)
    out += text(": ", bus_.reply_loss().lost, " of ", ReplyLoss::kRequests,
                " requests had no reply at first, expected ", ReplyLoss::kMost, " at most: the network loses datagrams");
  if (cause_board_) out += text(" (board ", *cause_board_);
  if (cause_channel_) out += text(", channel ", *cause_channel_ + 1);
  return cause_board_ ? out + ")" : out;
}

bool BoardSession::update() noexcept {
  all_valid_ = bus_.read();
  checked_ = state_;
  const double now = link_.now();
  since_check_ = now - checked_at_;
  checked_at_ = now;
  check_bus();
  // An open relay of any board removes the supply of all boards: it is reported as the cause.
  for (int b = 0; b < bus_.boards(); ++b) {
    if (bus_.valid(b)) check_relay(b, bus_.feedback(b));
  }
  for (int b = 0; b < bus_.boards(); ++b) {
    if (bus_.valid(b)) check_board(b);
  }
  if (all_valid_) advance_power_state();
  return all_valid_;
}

// Steps of the power-up: specification 14.5, #3 to #8.
void BoardSession::advance_power_state() noexcept {
  const double in_state = link_.now() - entered_;
  const auto all = [&](auto&& holds) {
    for (int b = 0; b < bus_.boards(); ++b) {
      if (!holds(b, bus_.feedback(b))) return false;
    }
    return true;
  };
  if (state_ == PowerState::kRelay) {
    if (all([](int, const BoardFeedback& f) { return f.status.relay_closed(); }))
      return enter(PowerState::kPower);
    if (in_state > options_.relay_timeout) {
      faults().note(Condition::kRelayOpen, link_.now());
      escalate(Reaction::kPowerOff, Condition::kRelayOpen);
    }
  } else if (state_ == PowerState::kPower) {
    if (all([](int, const BoardFeedback& f) {
          return f.status.supply_good() && !f.status.watchdog() && !f.status.supply_fault();
        }))
      return enter(PowerState::kAmps);
    if (in_state > options_.supply_timeout) {
      faults().note(Condition::kNoSupply, link_.now());
      escalate(Reaction::kPowerOff, Condition::kNoSupply);
    }
  } else if (state_ == PowerState::kAmps) {
    if (all([this](int b, const BoardFeedback& f) {
          for (int c = 0; c < kChannels; ++c) {
            if (safety(b, c).used && !f.status.amp_on(c)) return false;
          }
          return true;
        }))
      enter(PowerState::kOn);
  }
}

void BoardSession::set_command(int b, int c, double bits) noexcept {
  const ChannelSafety& s = safety(b, c);
  ChannelState& state = channel(b, c);
  const double zero = s.zero_command;
  if (!s.used || !std::isfinite(bits)) bits = zero;
  const double held = std::clamp(bits, zero - s.max_current, zero + s.max_current);
  state.command = nearest_word(held, s.zero_command);
  state.asked = true;
}

// Sets the next block of a board to zero currents and amplifiers off.
void BoardSession::command_off(int b) noexcept {
  BoardCommand& command = bus_.command(b);
  for (int c = 0; c < kChannels; ++c) {
    command.channel[c] = {true, false, AmpRequest::kOff, 0,
                                               safety(b, c).zero_command};
  }
  command.control = control::kAmpsOff;
  if (power_off_asked_ && off_cycles_ >= kAmpsFirst) command.control |= control::kPowerOff;
}

void BoardSession::command_channels(int b, AmpRequest amp) noexcept {
  for (int c = 0; c < kChannels; ++c) {
    const ChannelSafety& s = safety(b, c);
    ChannelState& state = channel(b, c);
    if (!s.used) continue;
    std::uint16_t value = s.zero_command;
    if (state_ == PowerState::kOn) {
      value = state.asked && all_valid_ ? state.command : all_valid_ ? s.zero_command : state.held;
    }
    state.held = value;
    std::rotate(state.sent.begin(), state.sent.end() - 1, state.sent.end());
    state.sent.front() = value;
    bus_.command(b).channel[c] = {true, false, amp, 0, value};
  }
}

bool BoardSession::amps_stay_on() const noexcept {
  for (int b = 0; b < bus_.boards(); ++b) {
    if (bus_.valid(b) && (bus_.feedback(b).status.word & control::kAmpsOff) != 0) return true;
  }
  return false;
}

void BoardSession::commit() noexcept {
  if (listens()) return;
  const bool off = state_ == PowerState::kOff || state_ == PowerState::kFault;
  const double in_state = link_.now() - entered_;
  const bool blind = off && !all_valid_;
  const bool disobeyed = off && in_state > kObeyBlocks && amps_stay_on();
  // A board that ignores commands is left to its watchdog: nothing is sent that would keep it alive (section 14.1).
  const bool silent = (disobeyed && in_state > kObeyRegisters) ||
                      (blind && in_state > kBlind && in_state < kBlind + kBite * options_.watchdog);
  bus_.set_silent(silent);
  if (silent) return;
  if (disobeyed) {
    for (int b = 0; b < bus_.boards(); ++b) bus_.switch_off_by_register(b, BoardBus::Off::kPower);
  }
  for (int b = 0; b < bus_.boards(); ++b) {
    BoardCommand& command = bus_.command(b);
    switch (state_) {
      case PowerState::kOff:
      case PowerState::kFault:
        command_off(b);
        break;
      case PowerState::kRelay:
        command_off(b);
        command.control |= control::kRelayClose;
        break;
      case PowerState::kPower:
        command_off(b);
        command.control = control::kAmpsOff | control::kPowerOn;
        break;
      case PowerState::kAmps:
        command_channels(b, AmpRequest::kOn);
        break;
      case PowerState::kOn:
        command_channels(b, AmpRequest::kKeep);
        break;
    }
    for (int c = 0; c < kChannels; ++c) channel(b, c).asked = false;
  }
  if (blind) {  // node numbers may have changed: off goes by broadcast
    bus_.switch_off(power_off_asked_ && off_cycles_ >= kAmpsFirst ? BoardBus::Off::kPower
                                                                  : BoardBus::Off::kAmps);
  } else {
    bus_.write();
  }
  if (bus_.link_lost()) escalate(Reaction::kPowerOff, Condition::kNotSent);
  if (off_cycles_ < kAmpsFirst) ++off_cycles_;
}

const char* BoardSession::power_on() noexcept {
  if (listens()) return "this session reads alone";
  if (state_ == PowerState::kFault) return "a fault was not acknowledged";
  if (state_ != PowerState::kOff) return "power is on, or on the way";
  if (bus_.state() != BusState::kRunning) return "the boards are not known";
  if (!all_valid_) return "the last read was not valid";
  for (int b = 0; b < bus_.boards(); ++b) {
    const BoardFeedback& f = bus_.feedback(b);
    if (bus_.rebooted(b)) return "a board was rebooted: start() again";
    if (f.status.supply_fault()) return "the motor supply has a fault";
    if (f.digital.encoder_supply_fault()) return "the encoders have no supply";
    for (int sensor = 0; sensor < 2; ++sensor) {
      if (f.temperature.valid(sensor) && f.temperature.celsius(sensor) > options_.warm)
        return "a board is too warm";
    }
    for (int c = 0; c < kChannels; ++c) {
      if (!safety(b, c).used) continue;
      if (safety(b, c).watch_pot_rail && at_rail(f.channel[c].pot))
        return "a pot is at the end of its range: outside, or its wire is gone";
      const EncoderWords& words = f.channel[c].encoder;
      if (encoder_overflow(words.position)) return "an encoder has run over";
      if (bus_.info(b).firmware >= 7 && encoder_error(words.period))
        return "an encoder reports an error";
    }
  }
  bus_.check_all_for_restart();
  power_off_asked_ = true;  // a later fault or power_off() switches the supply off as well
  enter(PowerState::kRelay);
  return nullptr;
}

void BoardSession::power_off() noexcept {
  if (state_ == PowerState::kOff) return;
  power_off_asked_ = true;
  enter(PowerState::kOff);
}

bool BoardSession::acknowledge() noexcept {
  if (state_ != PowerState::kFault) return state_ == PowerState::kOff;
  if (bus_.state() != BusState::kRunning || !all_valid_) return false;
  for (int b = 0; b < bus_.boards(); ++b) {
    if (bus_.rebooted(b)) return false;
  }
  power_off_asked_ = true;
  enter(PowerState::kOff);
  return true;
}

bool BoardSession::preload(int b, int c, std::int32_t counts) noexcept {
  const std::uint16_t where = address::of_channel(c, address::kPreload);
  if (is_powering_up() || !bus_.write_checked(b, where, preload_word(counts))) return false;
  std::uint32_t position = 0;
  return bus_.read_register(b, address::of_channel(c, address::kPosition), position) &&
         !encoder_overflow(position);
}

bool BoardSession::needs_preload(int b, int c) noexcept {
  std::uint32_t word = 0;
  return !bus_.read_register(b, address::of_channel(c, address::kPreload), word) ||
         (word & 0xFFFFFF) == kPreloadNever;
}

}  // namespace veridyn::dvrk
