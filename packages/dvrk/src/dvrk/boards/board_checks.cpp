#include <algorithm>
#include <cmath>

#include "dvrk/boards/board_session.hpp"

// Checks of a session in every cycle: specification 14.6 and conditions #17 to #24 of section 17.

namespace veridyn::dvrk {
namespace {

// Largest measured currents without an amplifier, in bits of the nominal 5242.88 per ampere: specification 14.6.
constexpr double kDisabledLimit = 524.0;    // 100 mA
constexpr double kUnpoweredLimit = 1049.0;  // 200 mA
constexpr double kNearLargest = 0.95;  // share of the largest current above which a motor may be stalled
constexpr double kRelayGrace = 0.050;  // [s] time within which the relay's contacts must close

}  // namespace

// Logs a condition of board index b and escalates the reaction to it.
void BoardSession::note(Condition condition, Reaction reaction, int b, std::optional<int> c,
                        std::uint32_t value) noexcept {
  faults().note(condition, link_.now(), bus_.info(b).id, c, value);
  escalate(reaction, condition, bus_.info(b).id, c);
}

// Escalates a lost link, lost replies, reads or writes, and a bus that is being scanned.
void BoardSession::check_bus() noexcept {
  if (bus_.link_lost()) escalate(Reaction::kPowerOff, Condition::kNotSent);
  if (bus_.reply_loss().too_many()) escalate(Reaction::kPowerOff, Condition::kLostReplies);
  if (bus_.state() != BusState::kRunning) escalate(Reaction::kAmpsOff, bus_.scan_reason());
  for (int b = 0; b < bus_.boards(); ++b) {
    const int id = bus_.info(b).id;
    if (bus_.lost_reads(b) >= options_.lost_reads) escalate(Reaction::kPowerOff, bus_.loss_reason(b), id);
    if (bus_.lost_writes(b) >= options_.lost_writes)
      escalate(Reaction::kAmpsOff, bus_.unconfirmed_reason(b), id);
    if (bus_.rebooted(b)) escalate(Reaction::kPowerOff, Condition::kRebooted, id);
  }
}

void BoardSession::check_board(int b) noexcept {
  const BoardFeedback& f = bus_.feedback(b);
  check_power(b, f);
  check_temperature(b, f);
  if (f.digital.encoder_supply_fault()) {
    note(Condition::kEncoder, Reaction::kPowerOff, b, {}, f.digital.word);
  }
  for (int c = 0; c < kChannels; ++c) {
    if (safety(b, c).used) check_channel(b, c, f);
  }
}

// Condition #20: a relay that is requested is open.
void BoardSession::check_relay(int b, const BoardFeedback& f) noexcept {
  if (checked_ == PowerState::kOff || checked_ == PowerState::kFault) return;
  const bool late = checked_ != PowerState::kRelay || link_.now() - entered_ > kRelayGrace;
  if (late && f.status.relay_requested() && !f.status.relay_closed())
    note(Condition::kRelayOpen, Reaction::kAmpsOff, b, {}, f.status.word);
}

// Conditions #17 to #19. In states kOff and kFault only a fault of the supply itself is reported.
void BoardSession::check_power(int b, const BoardFeedback& f) noexcept {
  const Status s = f.status;
  if (s.supply_fault()) note(Condition::kSupplyFault, Reaction::kPowerOff, b, {}, s.word);
  if (checked_ == PowerState::kOff || checked_ == PowerState::kFault) return;
  if (had_power() && s.watchdog()) note(Condition::kWatchdog, Reaction::kAmpsOff, b, {}, s.word);
  if (had_power() && (!s.supply_good() || !s.power_requested()))
    note(Condition::kNoSupply, Reaction::kAmpsOff, b, {}, s.word);
}

// Condition #23: a warm board is reported, a hot one is switched off.
void BoardSession::check_temperature(int b, const BoardFeedback& f) noexcept {
  for (int sensor = 0; sensor < 2; ++sensor) {
    const bool valid = f.temperature.valid(sensor);
    const double celsius = f.temperature.celsius(sensor);
    if (valid && celsius <= options_.warm) continue;
    const bool hot = valid && celsius > options_.hot;
    note(Condition::kTemperature, hot ? Reaction::kPowerOff : Reaction::kReport, b, {},
         f.temperature.word);
  }
}

// Conditions #17 to #24 of channel c.
void BoardSession::check_channel(int b, int c, const BoardFeedback& f) noexcept {
  const ChannelFeedback& one = f.channel[c];
  const bool rev8 = bus_.info(b).firmware >= 8;
  if (had_power() && (f.status.current_trip(c) || (rev8 && one.motor.current_trip())))
    note(Condition::kCurrentTrip, Reaction::kAmpsOff, b, c, f.status.word);
  check_amp(b, c, f);
  check_current(b, c, f);
  check_stall(b, c, f);
  check_encoder(b, c, f);
  check_pot(b, c, one);
}

// Condition #21: an amplifier is off after the grace of section 14.5 #8, or the board itself reports its fault
// (Rev 8).
void BoardSession::check_amp(int b, int c, const BoardFeedback& f) noexcept {
  ChannelState& state = channel(b, c);
  const double now = link_.now();
  const MotorStatus motor = f.channel[c].motor;
  if (checked_ == PowerState::kOn && bus_.info(b).firmware >= 8 && motor.amp_fault()) {
    note(Condition::kAmpOff, Reaction::kAmpsOff, b, c, motor.word);
    return;
  }
  if (!had_power() || f.status.amp_on(c)) {
    state.amp_missing_since.reset();
    return;
  }
  if (!state.amp_missing_since) state.amp_missing_since = now;
  if (now - *state.amp_missing_since < options_.amp_grace) return;
  note(Condition::kAmpOff, Reaction::kAmpsOff, b, c, f.status.word);
}

// Condition #23: the current of an amplifier that is on must lie between the last commands.
void BoardSession::check_current(int b, int c, const BoardFeedback& f) noexcept {
  ChannelState& state = channel(b, c);
  const ChannelSafety& s = safety(b, c);
  const double current = f.channel[c].current - s.zero_feedback;
  double least = 0.0, most = 0.0;
  double margin = f.status.power_requested() ? kDisabledLimit : kUnpoweredLimit;
  const bool driven = checked_ == PowerState::kOn && f.status.amp_on(c);
  if (driven) {
    const auto [low, high] = std::minmax_element(state.sent.begin(), state.sent.end());
    const double scale = s.feedback_per_command;
    least = scale * (*low - s.zero_command);
    most = scale * (*high - s.zero_command);
    margin = options_.follow.margin + options_.follow.share * std::max(std::abs(least), std::abs(most));
  }
  const bool excess = current < least - margin || current > most + margin;
  state.excess_cycles = excess ? state.excess_cycles + 1 : 0;
  if (state.excess_cycles > (driven ? options_.follow.cycles : options_.current_cycles))
    note(Condition::kOutOfBounds, Reaction::kPowerOff, b, c,
         f.channel[c].current);
}

// Detects a motor that stands still near its current limit, independently of the controller's estimates.
void BoardSession::check_stall(int b, int c, const BoardFeedback& f) noexcept {
  ChannelState& state = channel(b, c);
  const ChannelSafety& s = safety(b, c);
  if (s.rest_counts <= 0.0) return;
  const std::int32_t at = encoder_counts(f.channel[c].encoder.position);
  const bool near = std::abs(state.held - static_cast<double>(s.zero_command)) >= kNearLargest * s.max_current;
  const bool moves = std::abs(static_cast<double>(at) - state.stalled_at) > s.rest_counts;
  if (checked_ != PowerState::kOn || moves || (!near && state.stalled <= 0.0)) {
    state.stalled = 0.0;
    state.stalled_at = at;
    return;
  }
  state.stalled += near ? since_check_ : -since_check_;
  if (state.stalled > options_.stall)
    note(Condition::kStalled, Reaction::kPowerOff, b, c, f.channel[c].current);
}

// Condition #24: an encoder has overflowed or reports an impossible transition.
void BoardSession::check_encoder(int b, int c, const BoardFeedback& f) noexcept {
  const EncoderWords& words = f.channel[c].encoder;
  const bool overflow = encoder_overflow(words.position);
  const bool error = bus_.info(b).firmware >= 7 && encoder_error(words.period);
  if (!overflow && !error) return;
  note(Condition::kEncoder, overflow ? Reaction::kPowerOff : Reaction::kAmpsOff, b, c,
       overflow ? words.position : words.period);
}

// A lasting difference between pot and encoder switches off: specification 14.6, last line.
void BoardSession::check_pot(int b, int c, const ChannelFeedback& one) noexcept {
  ChannelState& state = channel(b, c);
  const ChannelSafety& s = safety(b, c);
  const double now = link_.now();
  const double difference =
      s.counts_to_position(encoder_counts(one.encoder.position)) - s.pot_to_position(one.pot);
  if (s.pot_tolerance <= 0.0 || !is_powering_up() || std::abs(difference) <= s.pot_tolerance) {
    state.pot_off_since.reset();
    return;
  }
  if (!state.pot_off_since) state.pot_off_since = now;
  if (now - *state.pot_off_since > s.pot_latency)
    note(Condition::kPot, Reaction::kPowerOff, b, c, one.pot);
}

}  // namespace veridyn::dvrk
