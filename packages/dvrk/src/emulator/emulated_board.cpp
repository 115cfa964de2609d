#include "emulator/emulated_board.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace veridyn::dvrk {
namespace {

constexpr Ticks ticks(double seconds) {
  return static_cast<Ticks>(seconds * kTicksPerSecond);
}

constexpr Ticks kAmpHold = ticks(0.040);    // wait of an amplifier after the motor voltage has risen: section 14.2
constexpr Ticks kAmpDelay = ticks(0.0025);  // additional wait with an I/O expander
constexpr Ticks kTripAfter = ticks(0.050);  // duration of an excess current that trips an amplifier: specification 14.3
constexpr int kTripFloor = 0x300;
constexpr int kTripMargin = 0x900;

}  // namespace

void StandingLoad::advance(double, const MotorDrive* drives, ChannelMotion* motions,
                           std::size_t channels) noexcept {
  for (std::size_t k = 0; k < channels; ++k)
    motions[k].current_bits = drives[k].voltage_mode ? 0.0 : drives[k].bits;
}

EmulatedBoard::EmulatedBoard(const BoardSetup& setup) : setup_(setup) {
  reboot(0);
}

void EmulatedBoard::reboot(Ticks now) noexcept {
  for (Channel& c : channels_) {
    const ChannelMotion motion = c.motion;  // the arm keeps its position while the board restarts
    c = Channel();
    if (setup_.io_expander) c.motor_config |= 1U << 25;
    c.motion = motion;
    c.encoder.power_up(motion.counts, now);
  }
  now_ = latched_at_ = last_write_ = power_since_ = good_since_ = now;
  watchdog_period_ = kWatchdogDefault;
  watchdog_tripped_ = watchdog_led_ = false;
  power_requested_ = relay_requested_ = power_path_ = supply_good_ = false;
  outputs_ = 0;
  query = 0;
  reboot_requested = false;
}

void EmulatedBoard::advance(Ticks now, const PowerChain& chain) noexcept {
  now_ = now;
  chain_live_ = !chain.emergency_stop && chain.relays_closed;
  const bool path = power_requested_ && chain.supply_on && chain_live_ && !faults.supply_fault;
  if (path && !power_path_) power_since_ = now;
  power_path_ = path;
  const bool good = path && now - power_since_ >= chain.rise;
  if (good && !supply_good_) good_since_ = now;
  supply_good_ = good;
  const Ticks period = static_cast<Ticks>(watchdog_period_) * kWatchdogTicks;
  if (period > 0 && now - last_write_ >= period) watchdog_tripped_ = true;
  for (int k = 0; k < kChannels; ++k) {
    Channel& c = channels_[k];
    if (!faults.stuck[k]) c.driven = c.dac;
    check_current(c, measured_current(k));
    if (watchdog_tripped_ || c.tripped) c.disabled = true;
  }
}

// Trips the amplifier after 50 ms of a current far above its command: specification 14.3.
void EmulatedBoard::check_current(Channel& c, std::uint16_t measured) noexcept {
  const int flows = std::abs(static_cast<int>(measured) - kZeroCurrent);
  const int asked = std::abs(static_cast<int>(c.dac) - kZeroCurrent);
  const bool at_end = c.dac < kTripMargin || c.dac > 0xFFFF - kTripMargin;
  bool exceeds = flows >= kTripFloor && !at_end && flows > asked + kTripMargin;
  if (c.mode == 1) exceeds = flows > static_cast<int>(c.motor_config & 0x7FFF);
  if ((c.motor_config >> 31) != 0) exceeds = false;
  if (!exceeds) {
    c.exceeds_since = -1;
    return;
  }
  if (c.exceeds_since < 0) c.exceeds_since = now_;
  if (now_ - c.exceeds_since >= kTripAfter) c.tripped = true;
}

void EmulatedBoard::clear_watchdog() noexcept {
  watchdog_tripped_ = false;
  last_write_ = now_;
}

void EmulatedBoard::clear_trip(Channel& c) noexcept {
  c.tripped = false;
  c.exceeds_since = -1;
}

// Approximately Gaussian: the sum of four numbers uniform in [-1, 1] has a variance of 4/3.
double EmulatedBoard::noise(double deviation) noexcept {
  if (deviation <= 0.0) return 0.0;
  double sum = 0.0;
  for (int k = 0; k < 4; ++k) {
    random_ ^= random_ << 13;
    random_ ^= random_ >> 7;
    random_ ^= random_ << 17;
    sum += static_cast<double>(random_ >> 11) * 0x1p-52 - 1.0;
  }
  return deviation * sum * 0.8660254037844386;
}

// Executes a request for an amplifier, which also needs power and no trip: specification 14.2.
void EmulatedBoard::apply_amp(Channel& c, AmpRequest request, bool power_before) noexcept {
  const bool wanted_off = request == AmpRequest::kKeep ? c.disabled : request == AmpRequest::kOff;
  const bool was = c.disabled;
  c.disabled = !power_before || watchdog_tripped_ || c.tripped || wanted_off;
  if (was && !c.disabled) c.enabled_at = now_;
}

// Executes a block write, channels first, then the control word: specification 10.5.
void EmulatedBoard::apply_command(const BoardCommand& command) noexcept {
  last_write_ = now_;
  if (faults.ignores_writes) return;
  for (size_t k = 0; k < kChannels; ++k) {
    const ChannelCommand& told = command.channel[k];
    Channel& c = channels_[k];
    const bool voltage = (c.motor_config >> 25 & 1U) != 0;
    if (told.valid && (told.mode == 0 || (told.mode == 1 && voltage))) {
      c.dac = told.value;
      c.mode = told.mode;
    }
    if (setup_.firmware < 8) continue;
    if (told.amp == AmpRequest::kOn) {
      clear_watchdog();  // of the whole board
      clear_trip(c);
    }
    apply_amp(c, told.amp, power_requested_);
  }
  const std::uint32_t honoured = setup_.firmware >= 9 ? ~0U : control::kRealTimeBits;
  apply_control(command.control & honoured);
}

void EmulatedBoard::apply_control(std::uint32_t word) noexcept {
  const bool power_before = power_requested_;
  const bool enables_power = (word & control::kPowerOn) == control::kPowerOn;
  const std::uint32_t amps_on = (word >> 8) & word & 0xFU;
  if (enables_power || amps_on != 0) clear_watchdog();
  for (int k = 0; k < kChannels; ++k) {
    const bool masked = ((word >> (8 + k)) & 1U) != 0;
    const bool on = ((word >> k) & 1U) != 0;
    if (enables_power || (masked && on)) clear_trip(channels_[k]);
    apply_amp(channels_[k],
              !masked ? AmpRequest::kKeep
              : on    ? AmpRequest::kOn
                      : AmpRequest::kOff,
              power_before);
  }
  if ((word & control::kPowerOff) != 0) power_requested_ = enables_power;
  if ((word & control::kRelayOpen) != 0)
    relay_requested_ = (word & control::kRelayClose) == control::kRelayClose;
  if ((word & control::kReboot) == control::kReboot && setup_.firmware >= 7)
    reboot_requested = true;
}

bool EmulatedBoard::amp_on(int channel) const noexcept {
  const Channel& c = channels_[channel];
  const bool held = now_ - good_since_ < kAmpHold;
  const bool late = setup_.io_expander && now_ - c.enabled_at < kAmpDelay;
  return !c.disabled && supply_good_ && !held && !late && !faults.amp[channel];
}

MotorDrive EmulatedBoard::drive(int channel) const noexcept {
  const Channel& c = channels_[channel];
  MotorDrive d;
  d.powered = amp_on(channel);
  d.voltage_mode = c.mode == 1;
  d.bits = d.powered ? static_cast<double>(faults.stuck[channel] ? c.driven : c.dac) - kZeroCurrent : 0.0;
  return d;
}

void EmulatedBoard::set_motion(int channel, const ChannelMotion& motion) noexcept {
  Channel& c = channels_[channel];
  c.motion = motion;
  c.motion.pot_bits += noise(setup_.pot_noise) + faults.pot[channel];
  if (faults.pot_wire[channel]) c.motion.pot_bits = 0.0;
  c.motion.current_bits += noise(setup_.current_noise);
  c.encoder.move(motion.counts, now_);
}

std::uint16_t EmulatedBoard::measured_current(int channel) const noexcept {
  const double bits = channels_[channel].motion.current_bits +
                      faults.current[channel] + kZeroCurrent;
  return static_cast<std::uint16_t>(std::clamp(std::round(bits), 0.0, 65535.0));
}

Status EmulatedBoard::status() const noexcept {
  const auto bit = [](bool set, int k) { return set ? 1U << k : 0U; };
  const int channels = faults.wrong_channels >= 0 ? faults.wrong_channels : kChannels;
  const int id = faults.wrong_id >= 0 ? faults.wrong_id : setup_.id;
  const bool rev8 = setup_.firmware >= 8;
  Status s;
  s.word = (static_cast<std::uint32_t>(channels) << 28) | (static_cast<std::uint32_t>(id) << 24) |
           bit(watchdog_tripped_, 23) | bit(true, 21) | bit(true, 20) | bit(supply_good_, 19) |
           bit(power_requested_, 18) | bit(relay_closed(), 17) | bit(relay_requested_, 16) |
           bit(faults.supply_fault, 15) | bit(rev8 && setup_.senses_chain && chain_live_, 14) |
           bit(rev8 && setup_.io_expander, 12);
  for (int k = 0; k < kChannels; ++k) {
    const Channel& c = channels_[k];
    s.word |= bit(amp_on(k), 8 + k) | bit(c.tripped, 4 + k);
    s.word |= bit(rev8 ? amp_on(k) : !c.disabled, k);
  }
  return s;
}

// The motor status word of Rev 8 on: specification 9.1.
MotorStatus EmulatedBoard::motor_status(int channel) const noexcept {
  const Channel& c = channels_[channel];
  const auto bit = [](bool set, int k) { return set ? 1U << k : 0U; };
  const bool on = amp_on(channel);
  const bool fault = !c.disabled && faults.amp[channel] && supply_good_ &&
                     now_ - good_since_ >= kAmpHold;
  MotorStatus m;
  m.word = bit(on, 29) | bit(!c.disabled, 28) | (static_cast<std::uint32_t>(c.mode) << 24) |
           bit(c.mode == 0, 20) | bit(c.tripped, 17) | bit(fault, 16) | c.dac;
  return m;
}

ChannelFeedback EmulatedBoard::channel_feedback(int channel) const noexcept {
  const Channel& c = channels_[channel];
  ChannelFeedback f;
  f.pot = static_cast<std::uint16_t>(std::clamp(std::round(c.motion.pot_bits), 0.0, 65535.0));
  f.current = measured_current(channel);
  f.encoder = c.encoder.words(setup_.firmware, now_);
  f.motor = motor_status(channel);
  return f;
}

BoardFeedback EmulatedBoard::latch() noexcept {
  BoardFeedback f;
  const Ticks since = now_ - latched_at_ - 1;
  f.timestamp =
      faults.stops_clock ? 0U : static_cast<std::uint32_t>(std::clamp<Ticks>(since, 0, 0xFFFFFFFF));
  latched_at_ = now_;
  f.status = status();
  f.digital.word = digital_word();
  f.temperature.word = temperatures;
  for (int k = 0; k < kChannels; ++k) f.channel[k] = channel_feedback(k);
  return f;
}

std::uint32_t EmulatedBoard::digital_word() const noexcept {
  std::uint32_t word =
      (faults.encoder_supply ? 1U << 31 : 0U) |
      (setup_.firmware >= 8 && setup_.io_expander && supply_good_ ? 1U << 28 : 0U) | (outputs_ << 12) | (digital_inputs & 0xFFFU);
  for (int k = 0; k < kChannels; ++k) {
    const EmulatedEncoder& e = channels_[k].encoder;
    word |= (e.line_a() ? 1U << (24 + k) : 0U) | (e.line_b() ? 1U << (20 + k) : 0U);
  }
  return word;
}

bool EmulatedBoard::write_block(std::uint16_t where, QuadletView block) noexcept {
  if ((where >> 12) != 0) {  // other address spaces do not act on the arm
    last_write_ = now_;
    for (std::size_t k = 0; k < block.size() && (where >> 12) == 8; ++k)
      waveform_[((where & 0xFFFU) + k) % waveform_.size()] = block[k];
    return true;
  }
  BoardCommand command;
  if (!find_command(block, setup_.id, setup_.firmware, command)) return false;
  apply_command(command);
  return true;
}

}  // namespace veridyn::dvrk
