#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "veridyn/emulator/board_load.hpp"
#include "veridyn/dvrk/protocol/bytes.hpp"
#include "veridyn/dvrk/protocol/command.hpp"
#include "veridyn/emulator/emulated_encoder.hpp"
#include "veridyn/dvrk/protocol/feedback.hpp"
#include "veridyn/dvrk/protocol/protocol.hpp"

namespace veridyn::dvrk {

struct BoardSetup {
  int id = 0;  ///< Position of the rotary switch
  int firmware = 8;
  std::uint32_t hardware = kHardwareQla1;
  std::string qla_serial = "QLA 0000-00";
  std::string fpga_serial = "FPGA 0000-00";
  /// QLA 1.5: amplifiers switch on 2.5 ms later, voltage mode exists, the motor supply has a comparator
  bool io_expander = false;
  bool senses_chain = true;          ///< Rev 8 on: status bit 14
  double pot_noise = 0.0;            ///< standard deviation [bits]
  double current_noise = 0.0;        ///< standard deviation of measured currents [bits]
  std::vector<std::uint8_t> dallas;  ///< memory of an instrument's chip; empty: no chip
};

/// The electrical environment of the boards: one power supply, one chain of switches.
struct PowerChain {
  bool emergency_stop = false;  ///< pressed
  bool supply_on = true;
  bool relays_closed = false;  ///< relays of all boards in series are closed; set by the emulator
  Ticks rise = 983040;         ///< time from power enabled to voltage present: 20 ms
};

/// Faults of a board.
struct BoardFaults {
  bool supply_fault = false;
  bool relay_stuck_open = false;
  bool encoder_supply = false;
  bool ignores_writes = false;                    ///< real-time writes change nothing
  bool ignores_registers = false;                 ///< writes of single registers change nothing
  bool stops_clock = false;                       ///< timestamps are zero
  int wrong_id = -1;                              ///< the status shows this id
  int wrong_channels = -1;                        ///< the status shows this many
  bool skips_query = false;                       ///< never writes its block into the hub
  int wrong_sequence = 0;                         ///< added to the sequence in its hub block
  int wrong_block_size = 0;                       ///< added to the size in its hub block; Rev 8 on
  std::array<bool, kChannels> amp{};              ///< amplifier fails
  std::array<bool, kChannels> stuck{};            ///< the amplifier keeps its present current
  std::array<std::int32_t, kChannels> current{};  ///< added to the measured current [bits]
  std::array<double, kChannels> pot{};            ///< added to the pot [bits]
  std::array<bool, kChannels> pot_wire{};         ///< the wire is broken: the pot reads zero
};

/// One FPGA board with its QLA: registers (specification 7), amplifier logic (14.2), watchdog (14.1),
/// current check (14.3). It has no sockets and no clock: advance() provides the time.
class EmulatedBoard {
 public:
  explicit EmulatedBoard(const BoardSetup& setup);

  const BoardSetup& setup() const { return setup_; }

  /// Power cycle or reboot command: registers get their power-up values.
  void reboot(Ticks now) noexcept;

  /// Executes timers and checks up to `now`.
  void advance(Ticks now, const PowerChain& chain) noexcept;

  /// One register; 0 for an unknown address. A write also feeds the watchdog.
  std::uint32_t read(std::uint16_t address) const noexcept;
  void write(std::uint16_t address, std::uint32_t data) noexcept;
  /// A block at any address except the hub's; zeros beyond its end.
  void read_block(std::uint16_t address, QuadletSpan out) noexcept;
  /// @returns false: a real-time block without a command for this board.
  bool write_block(std::uint16_t address, QuadletView block) noexcept;
  /// Latches the real-time feedback and restarts its timestamp.
  BoardFeedback latch() noexcept;

  MotorDrive drive(int channel) const noexcept;  ///< output of the amplifier to its motor
  /// Moves the encoder; stores pot and current with their noise and faults.
  void set_motion(int channel, const ChannelMotion& motion) noexcept;

  Status status() const noexcept;
  MotorStatus motor_status(int channel) const noexcept;
  bool amp_on(int channel) const noexcept;  ///< enabled, with supply voltage and without fault
  bool watchdog_tripped() const { return watchdog_tripped_; }
  bool relay_closed() const { return relay_requested_ && !faults.relay_stuck_open; }
  std::uint16_t dac(int channel) const { return channels_[channel].dac; }
  EmulatedEncoder& encoder(int channel) { return channels_[channel].encoder; }

  /// reboot by command 21:20 = 11, which the emulator executes
  bool reboot_requested = false;
  std::uint32_t temperatures = 0x3234;  ///< 25 and 26 degrees
  std::uint32_t digital_inputs = 0;     ///< bits 11:0 of section 13
  std::uint32_t ethernet = kEthernetHealthy;
  std::uint32_t phy_result = 0;  ///< register 2
  std::uint32_t ip_address = 0xFFFFFFFF;
  std::uint32_t query = 0;  ///< register 0x1800
  BoardFaults faults;

 private:
  struct Channel {
    std::uint16_t dac = kZeroCurrent;
    std::uint16_t driven = kZeroCurrent;  ///< command that the amplifier executes
    std::uint8_t mode = 0;
    bool disabled = true;
    bool tripped = false;
    Ticks exceeds_since = -1;  ///< current check
    Ticks enabled_at = 0;
    std::uint32_t motor_config = kMotorConfigDefault;
    std::uint32_t dout_timing = 0;
    ChannelMotion motion;
    EmulatedEncoder encoder;
  };

  void apply_amp(Channel& c, AmpRequest request, bool power_before) noexcept;
  void apply_command(const BoardCommand& command) noexcept;
  void apply_control(std::uint32_t word) noexcept;  ///< executes a control word: section 7.3
  void clear_watchdog() noexcept;  ///< resets the trip and restarts the period
  static void clear_trip(Channel& c) noexcept;
  double noise(double deviation) noexcept;
  void check_current(Channel& c, std::uint16_t measured) noexcept;
  std::uint16_t measured_current(int channel) const noexcept;  ///< [bits of the ADC], faults included
  std::uint32_t digital_word() const noexcept;  ///< register 10: section 13
  ChannelFeedback channel_feedback(int channel) const noexcept;
  std::uint32_t read_channel(int channel, int offset) const noexcept;  ///< offset: address::Offset
  void write_channel(int channel, int offset, std::uint32_t data) noexcept;
  std::uint32_t dallas_status() const noexcept;
  std::uint32_t dallas_quadlet(std::size_t place) const noexcept;
  void command_prom(std::uint32_t command) noexcept;
  void command_qla_prom(std::uint32_t command) noexcept;  ///< reads from the QLA's serial number

  BoardSetup setup_;
  std::array<Channel, kChannels> channels_;
  Ticks now_ = 0;
  Ticks latched_at_ = 0;
  Ticks last_write_ = 0;
  Ticks power_since_ = 0;  ///< time from which supply and chain can provide voltage
  Ticks good_since_ = 0;
  std::uint32_t watchdog_period_ = kWatchdogDefault;
  bool watchdog_led_ = false;
  bool watchdog_tripped_ = false;
  bool power_requested_ = false;
  bool relay_requested_ = false;
  bool power_path_ = false;
  bool supply_good_ = false;
  bool chain_live_ = false;
  std::uint32_t outputs_ = 0;
  std::uint32_t fpga_prom_result_ = 0;
  std::uint32_t qla_prom_result_ = 0;
  std::size_t dallas_from_ = 0;  ///< byte of the chip
  bool dallas_asked_ = false;
  std::uint64_t random_ = 0x9E3779B97F4A7C15;
  std::array<std::uint32_t, 1024> waveform_{};  ///< section 7, space 8
  std::array<std::uint8_t, 64> qla_prom_{};
  std::array<std::uint8_t, 64> fpga_prom_{};
};

}  // namespace veridyn::dvrk
