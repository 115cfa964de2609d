#pragma once

#include <cstdint>

#include "veridyn/dvrk/protocol/protocol.hpp"

namespace veridyn::dvrk {

/// The status register: specification 7.2. Channels count from 0.
struct Status {
  std::uint32_t word = 0;

  bool bit(int k) const { return ((word >> k) & 1U) != 0; }
  int channels() const { return static_cast<int>(word >> 28); }
  int board() const { return static_cast<int>((word >> 24) & 0xF); }
  bool watchdog() const { return bit(23); }
  bool supply_good() const { return bit(19); }  ///< motor supply voltage is there (mv_good)
  bool power_requested() const { return bit(18); }
  bool relay_closed() const { return bit(17); }
  bool relay_requested() const { return bit(16); }
  bool supply_fault() const { return bit(15); }
  bool io_expander() const { return bit(12); }
  bool amp_on(int channel) const { return bit(8 + channel); }
  bool current_trip(int channel) const { return bit(4 + channel); }
};

/// The motor status of Rev 8 on: specification 9.1.
struct MotorStatus {
  std::uint32_t word = 0;

  bool bit(int k) const { return ((word >> k) & 1U) != 0; }
  bool amp_on() const { return bit(29); }
  bool amp_requested() const { return bit(28); }
  bool current_trip() const { return bit(17); }
  bool amp_fault() const { return bit(16); }
  std::uint16_t command() const { return static_cast<std::uint16_t>(word); }
};

/// The digital I/O word: specification 13. Channels count from 0.
struct DigitalInputs {
  std::uint32_t word = 0;

  bool bit(int k) const { return ((word >> k) & 1U) != 0; }
  bool encoder_supply_fault() const { return bit(31); }
  bool home(int channel) const { return bit(channel); }
  /// Outputs of the board, one bit each, as logical values.
  unsigned outputs() const { return ~(word >> 12) & 0xFU; }
};

/// Value of register 6 for logical outputs: the hardware inverts (specification 13).
constexpr std::uint32_t digital_output_word(unsigned mask, unsigned values) {
  return ((mask & 0xFU) << 8) | (~values & mask & 0xFU);
}

/// Temperatures of sensors 0 and 1 in half degrees: specification 7.1; 0xFF is no measurement.
struct Temperatures {
  std::uint32_t word = 0;

  std::uint8_t raw(int sensor) const {
    return static_cast<std::uint8_t>(sensor == 0 ? word >> 8 : word);
  }
  bool valid(int sensor) const { return raw(sensor) != 0xFF; }
  double celsius(int sensor) const { return 0.5 * raw(sensor); }  ///< [degC]; only if valid()
};

}  // namespace veridyn::dvrk
