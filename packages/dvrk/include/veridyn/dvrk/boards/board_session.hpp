#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "veridyn/dvrk/protocol/analog.hpp"
#include "veridyn/dvrk/boards/board_bus.hpp"

namespace veridyn::dvrk {

/// Limits of a motor channel in bits, so that the boards' safety does not depend on a conversion to SI units.
struct ChannelSafety {
  bool used = false;
  std::uint16_t zero_command = kZeroCurrent;  ///< DAC bits of no current, by calibration
  double zero_feedback = kZeroCurrent;        ///< ADC bits of no current
  double feedback_per_command = 1.0;          ///< ADC bits for one DAC bit
  double max_current = 0.0;                   ///< largest |command - zero| [bits]
  /// Pot against encoder: positions in any unit. Tolerance 0: not compared.
  LinearScale counts_to_position;
  LinearScale pot_to_position;
  double pot_tolerance = 0.0;
  double pot_latency = 0.010;   ///< [s] time for which the tolerance may be exceeded
  bool watch_pot_rail = false;  ///< a pot at an end of its converter prevents power-up
  double rest_counts = 0.0;     ///< motion during SessionOptions::stall below which a motor stands still; 0: not checked
};

/// True if a pot's reading [bits] is at an end of the converter: it is invalid, or its wire is broken. 16
/// bits are 1.1 mV.
constexpr bool at_rail(double pot_bits) {
  return pot_bits <= 16.0 || pot_bits >= 65535.0 - 16.0;
}

/// The measured current of an amplifier that is on must match one of the last commands within `margin` [bits]
/// and `share` of that command; otherwise power is switched off after this many cycles.
struct CurrentFollowing {
  int cycles = 10;
  double margin = 262.0;  ///< 50 mA: specification 14.6
  double share = 0.1;
};

struct SessionOptions {
  BusOptions bus;
  /// Limits by index of the board in ascending ids; missing boards have no channel in use.
  std::vector<std::array<ChannelSafety, kChannels>> channels;
  double watchdog = 0.030;         ///< [s]; 0 is refused (specification 14.1)
  int lost_reads = 3;              ///< successive lost reads after which power is switched off
  int lost_writes = 3;             ///< successive lost writes after which amplifiers are switched off
  int current_cycles = 100;        ///< cycles of a current without an amplifier, then power off (specification 14.6)
  CurrentFollowing follow;
  double stall = 0.25;             ///< [s] near its largest current at a standstill, after which power is switched off
  double relay_timeout = 0.2;      ///< [s] limit for the relays to close
  double supply_timeout = 3.0;     ///< [s] limit for the motor supply to come up
  double amp_grace = 0.0455;       ///< [s] for an amplifier to come up: 42.5 ms (section 14.2) and 3 ms of transmission
  double off_timeout = 0.5;        ///< [s] within which boards must confirm that they are off
  double warm = 60.0, hot = 65.0;  ///< [degC] limits above which a board is reported, and switched off
};

/// Status of the boards after switching off.
enum class OffState {
  kConfirmed,  ///< every board in use was read: amplifiers off, power not requested
  kNotAsked,   ///< the session never wrote, and needs no confirmation
  kPowerOn,    ///< amplifiers are off, but a board still requests power
  kAmpsOn,     ///< an amplifier is on
  kUnknown     ///< a board could not be read
};
const char* describe(OffState state);

/// Stage of the power-up sequence.
enum class PowerState {
  kOff,    ///< amplifiers and power are commanded off in every cycle
  kRelay,  ///< the safety relay closes
  kPower,  ///< the motor supply is being switched on
  kAmps,   ///< amplifiers come up with zero current
  kOn,     ///< commands take effect
  kFault   ///< off, until acknowledge()
};

const char* describe(PowerState state);

/// A session with boards that drive an arm: power-up and power-down (specification 14.5), checks in every
/// cycle (14.6, 17), and currents in state kOn only. Any fault ends in kFault, where amplifiers are
/// commanded off in every cycle; nothing restarts by itself. One cycle is update(), set_command()
/// for every channel, commit().
///
/// With BusOptions::access other than kDrive nothing is written at all: update() reads and checks,
/// commit() and shutdown() do nothing, power_on() refuses.
///
/// Parameters `board` and `b` are indices of boards in ascending ids; `channel` and `c` count from 0.
///
/// The destructor switches off: amplifiers, power, by broadcast, repeated.
class BoardSession {
 public:
  /// @throws InvalidInput  as BoardBus; a watchdog of 0 or beyond 0.34 s, a limit that is not
  ///                       positive.
  BoardSession(DatagramLink& link, const SessionOptions& options);
  ~BoardSession();
  BoardSession(const BoardSession&) = delete;
  BoardSession& operator=(const BoardSession&) = delete;

  /// Finds the boards, switches them off, sets the watchdogs and verifies them. Call it again after a board
  /// has restarted, or after a scan that was rejected.
  /// @throws InvalidInput  as BoardBus::start(); a watchdog cannot be set.
  void start();

  /// Reads all boards, checks them, and continues the power-up. @returns true if all are valid.
  bool update() noexcept;
  /// Sets the motor current in state kOn [DAC bits], limited. Valid for one commit().
  void set_command(int board, int channel, double bits) noexcept;
  /// Sends: commands in state kOn, zero currents otherwise. If a read was invalid, the last
  /// commands are held.
  void commit() noexcept;

  /// Begins to power up. @returns nullptr, or the reason for a refusal.
  const char* power_on() noexcept;
  /// Switches amplifiers off with the next commit(), then power.
  void power_off() noexcept;
  /// kFault -> kOff. @returns false: the bus is not running, or a board has restarted: call start().
  bool acknowledge() noexcept;
  /// Switches off by broadcast and by register, repeatedly until every board in use reads as off,
  /// for at most SessionOptions::off_timeout. If a link loses writes, or boards do not answer, the
  /// result differs from kConfirmed: the state is then unknown, and only the emergency stop helps.
  OffState shutdown() noexcept;

  /// Loads an encoder and verifies it. @returns false: power is on, the value is not there, or the overflow bit stays.
  bool preload(int board, int channel, std::int32_t counts) noexcept;
  /// False only if the board reports a preload since its start.
  bool needs_preload(int board, int channel) noexcept;

  PowerState state() const { return state_; }
  /// The condition that led to kFault; kNoReply before a fault.
  Condition cause() const { return cause_; }
  /// cause() as text, with the board and the channel concerned.
  std::string cause_text() const;
  BoardBus& bus() { return bus_; }
  const BoardBus& bus() const { return bus_; }
  FaultLog& faults() { return bus_.faults(); }
  const FaultLog& faults() const { return bus_.faults(); }
  bool listens() const { return options_.bus.access != Access::kDrive; }

 private:
  enum class Reaction { kReport, kAmpsOff, kPowerOff };
  struct ChannelState {
    std::uint16_t command = kZeroCurrent;
    std::uint16_t held = kZeroCurrent;
    bool asked = false;
    int excess_cycles = 0;
    std::array<std::uint16_t, 4> sent{};  ///< last commands; older ones may still be in effect if writes were lost
    std::optional<double> amp_missing_since;
    std::optional<double> pot_off_since;
    double stalled = 0.0;            // [s] near its largest current, minus the time below it
    std::int32_t stalled_at = 0;     // [counts] position at which the motor last moved
  };

  const ChannelSafety& safety(int b, int c) const {
    return channels_[b][c];
  }
  ChannelState& channel(int b, int c) {
    return states_[b][c];
  }
  bool had_power() const { return checked_ == PowerState::kAmps || checked_ == PowerState::kOn; }  ///< when the checks began
  bool is_powering_up() const { return state_ != PowerState::kOff && state_ != PowerState::kFault; }  ///< true in kOn as well
  void enter(PowerState state) noexcept;  ///< changes the state and restarts its time
  void escalate(Reaction reaction, Condition condition, std::optional<int> board = {},
             std::optional<int> channel = {}) noexcept;
  void note(Condition condition, Reaction reaction, int b, std::optional<int> c,
            std::uint32_t value) noexcept;
  void check_bus() noexcept;
  void check_board(int b) noexcept;  ///< all checks of a valid board except that of its relay
  void check_relay(int b, const BoardFeedback& f) noexcept;
  void check_power(int b, const BoardFeedback& f) noexcept;
  void check_temperature(int b, const BoardFeedback& f) noexcept;
  void check_channel(int b, int c, const BoardFeedback& f) noexcept;
  void check_amp(int b, int c, const BoardFeedback& f) noexcept;
  void check_current(int b, int c, const BoardFeedback& f) noexcept;
  void check_stall(int b, int c, const BoardFeedback& f) noexcept;
  void check_encoder(int b, int c, const BoardFeedback& f) noexcept;
  void check_pot(int b, int c, const ChannelFeedback& f) noexcept;
  void advance_power_state() noexcept;
  void command_off(int b) noexcept;
  OffState off_state() noexcept;
  bool amps_stay_on() const noexcept;  ///< true if a valid board shows an amplifier on
  /// Sets the next block of a board: zero currents before kOn, then the commands; after a lost read the last ones.
  void command_channels(int b, AmpRequest amp) noexcept;

  DatagramLink& link_;
  SessionOptions options_;
  BoardBus bus_;
  std::vector<std::array<ChannelSafety, kChannels>> channels_;
  std::vector<std::array<ChannelState, kChannels>> states_;
  PowerState state_ = PowerState::kOff;
  double checked_at_ = 0.0, since_check_ = 0.0;  // [s] time of the last checks of valid feedback, and since those before
  PowerState checked_ = PowerState::kOff;  ///< state_ when the cycle's checks began
  Condition cause_ = Condition::kNoReply;
  std::optional<int> cause_board_ = {}, cause_channel_ = {};  ///< id, and channel from 0
  double entered_ = 0.0;
  bool all_valid_ = false;
  bool started_ = false;
  bool power_off_asked_ = true;  ///< switch off the supply as well, in kOff and kFault
  int off_cycles_ = 0;
};

}  // namespace veridyn::dvrk
