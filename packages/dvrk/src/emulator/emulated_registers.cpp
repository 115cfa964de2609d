#include <algorithm>
#include <cstring>

#include "emulator/emulated_board.hpp"

// Registers of an emulated board that are not the real-time blocks: specification 7.

namespace veridyn::dvrk {
namespace {

constexpr std::uint32_t kFpgaPromRead = 0x03000000;  // commands of the memories: specification 7.6
constexpr std::uint32_t kFpgaSerialAt = 0x1FFF00;
constexpr std::uint32_t kFpgaPromIdentify = 0x9F000000;
constexpr std::uint32_t kFpgaPromStatus = 0x05000000;
constexpr std::uint32_t kFpgaPromId = 0x00202015;
constexpr std::uint32_t kQlaPromRead = 0xFE000000;
constexpr std::uint32_t kQlaPromReadByte = 0x03000000;
constexpr std::uint32_t kDallasFamily = 0x0B;  // DS2505
constexpr std::uint32_t kDallasEnabled = 1U << 0;
constexpr std::uint32_t kDallasSuccess = 1U << 1;        // bits 2:1
constexpr std::uint32_t kDallasBothDirections = 1U << 3;  // set if the board can read its output DOUT back
constexpr std::uint32_t kFpgaPromWords = 64;

// Fills a memory with the characters of the string, then 0xFF.
template <std::size_t N>
void fill(std::array<std::uint8_t, N>& prom, const std::string& text) {
  prom.fill(0xFF);
  std::memcpy(prom.data(), text.data(), std::min(N, text.size()));
}

}  // namespace

std::uint32_t EmulatedBoard::read_channel(int channel, int offset) const noexcept {
  const Channel& c = channels_[channel];
  const ChannelFeedback f = channel_feedback(channel);
  switch (offset) {
    case address::kAnalog:
      return (static_cast<std::uint32_t>(f.pot) << 16) | f.current;
    case address::kDac:
      return (setup_.firmware >= 8 ? 0U : 0x00300000U) | c.dac;
    case address::kPreload:
      return c.encoder.last_preload();
    case address::kPosition:
      return f.encoder.position;
    case address::kPeriod:
      return f.encoder.period;
    case address::kQuarter1:
      return f.encoder.quarter1;
    case address::kDoutTiming:
      return c.dout_timing;
    case address::kQuarter5:
      return setup_.firmware >= 7 ? f.encoder.quarter5 : 0;
    case address::kRunning:
      return setup_.firmware >= 7 ? f.encoder.running : 0;
    case address::kMotorConfig:
      return setup_.firmware >= 8 ? c.motor_config : 0;
    case address::kMotorStatus:
      return setup_.firmware >= 8 ? f.motor.word : 0;
    default:
      return 0;
  }
}

// Register 13 (Rev 7 on): result of the last command to the instrument's chip, which is never busy.
std::uint32_t EmulatedBoard::dallas_status() const noexcept {
  if (setup_.firmware < 7) return 0;
  const std::uint32_t word = kDallasEnabled | kDallasBothDirections;
  if (setup_.dallas.empty()) return word;
  return word | (kDallasFamily << 24) | (dallas_asked_ ? kDallasSuccess : 0U);
}

// The chip's memory from the byte that the last command selected.
std::uint32_t EmulatedBoard::dallas_quadlet(std::size_t place) const noexcept {
  std::uint32_t word = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    const std::size_t at = dallas_from_ + 4 * place + k;
    word = (word << 8) | (at < setup_.dallas.size() ? setup_.dallas[at] : 0U);
  }
  return word;
}

std::uint32_t EmulatedBoard::read(std::uint16_t where) const noexcept {
  if (where == address::kHubQuery) return query;
  if (where == 0x3001) return 0;  // QLA PROM: idle
  if (where == 0x3002) return qla_prom_result_;
  if ((where >> 12) == 6) return dallas_quadlet(where & 0xFFFU);
  if ((where >> 12) == 8) return waveform_[where & 0x3FFU];
  if ((where >> 12) != 0) return 0;
  const int channel = ((where >> 4) & 0xF) - 1;
  if (channel >= 0) return channel < kChannels ? read_channel(channel, where & 0xF) : 0;
  switch (where) {
    case address::kStatus:
      return status().word;
    case address::kPhyResult:
      return phy_result;
    case address::kWatchdog:
      return watchdog_period_ | (watchdog_led_ ? 0x80000000U : 0U);
    case address::kHardware:
      return setup_.hardware;
    case address::kTemperature:
      return temperatures & 0xFFFF;
    case address::kDigitalOut:
      return outputs_;
    case address::kFirmware:
      return static_cast<std::uint32_t>(setup_.firmware);
    case address::kDallas:
      return dallas_status();
    case address::kFpgaPromResult:
      return fpga_prom_result_;
    case address::kDigitalIn:
      return digital_word();
    case address::kIpAddress:
      return setup_.firmware >= 7 ? ip_address : 0;
    case address::kEthernet:
      return ethernet;
    default:
      return 0;
  }
}

void EmulatedBoard::write_channel(int channel, int offset, std::uint32_t data) noexcept {
  Channel& c = channels_[channel];
  switch (offset) {
    case address::kDac: {
      BoardCommand one;  // a register write has the same word as a block
      std::array<std::uint8_t, 24> block{};
      const QuadletSpan span({block.data(), 4 * write_quadlets(setup_.firmware)});
      one.board = static_cast<std::uint8_t>(setup_.id);
      encode_command(one, setup_.firmware, span);
      span.set(static_cast<size_t>(channel) + (setup_.firmware >= 8 ? 1 : 0), data);
      if (find_command(span, setup_.id, setup_.firmware, one)) apply_command(one);
      break;
    }
    case address::kPreload:
      c.encoder.preload(data);
      break;
    case address::kDoutTiming:
      c.dout_timing = data;
      break;
    case address::kMotorConfig: {  // section 7.4: mask bits select the fields to load
      if (setup_.firmware < 8) break;
      std::uint32_t kept = c.motor_config;
      if ((data & (1U << 24)) != 0) kept = (kept & ~0x7FFFU) | (data & 0x7FFFU);
      if ((data & (1U << 25)) != 0) kept = (kept & ~0x00FF0000U) | (data & 0x00FF0000U);
      c.motor_config = (kept & ~0xC0000000U) | (data & 0xC0000000U);
      break;
    }
    default:
      break;
  }
}

// Executes a command to the memory that holds the serial number: specification 7.6.
void EmulatedBoard::command_prom(std::uint32_t command) noexcept {
  switch (command & 0xFF000000U) {
    case kFpgaPromRead:
      fill(fpga_prom_, (command & 0xFFFFFFU) == kFpgaSerialAt ? setup_.fpga_serial : "");
      fpga_prom_result_ = kFpgaPromWords;
      break;
    case kFpgaPromIdentify:
      fpga_prom_result_ = kFpgaPromId;
      break;
    case kFpgaPromStatus:
      fpga_prom_result_ = 0;
      break;
    default:
      break;
  }
}

void EmulatedBoard::command_qla_prom(std::uint32_t command) noexcept {
  const std::size_t first = (command >> 8) & 0xFFFF;
  const bool there = first < setup_.qla_serial.size();
  if ((command & 0xFF000000U) == kQlaPromRead)
    fill(qla_prom_, there ? setup_.qla_serial.substr(first) : "");
  if ((command & 0xFF000000U) == kQlaPromReadByte)
    qla_prom_result_ = there ? static_cast<std::uint8_t>(setup_.qla_serial[first]) : 0xFFU;
}

void EmulatedBoard::write(std::uint16_t where, std::uint32_t data) noexcept {
  last_write_ = now_;
  if (where == address::kHubQuery) query = data;
  if (faults.ignores_registers) return;
  if (where == address::kQlaPromCommand) command_qla_prom(data);
  if (where == address::kFpgaPromCommand) command_prom(data);
  if ((where >> 12) == 8) waveform_[where & 0x3FFU] = data;
  if ((where >> 12) != 0) return;
  const int channel = ((where >> 4) & 0xF) - 1;
  if (channel >= 0) {
    if (channel < kChannels) write_channel(channel, where & 0xF, data);
    return;
  }
  switch (where) {
    case address::kStatus:
      apply_control(data);
      break;
    case address::kWatchdog:
      watchdog_period_ = data & 0xFFFF;
      watchdog_led_ = setup_.firmware >= 8 && (data >> 31) != 0;
      break;
    case address::kDigitalOut: {
      const std::uint32_t mask = (data >> 8) & 0xF;
      outputs_ = (outputs_ & ~mask) | (data & mask);
      break;
    }
    case address::kIpAddress:
      ip_address = data;
      break;
    case address::kDallas:  // the data select the first byte of the next read
      dallas_from_ = data >> 16;
      dallas_asked_ = true;
      break;
    default:
      break;
  }
}

void EmulatedBoard::read_block(std::uint16_t where, QuadletSpan out) noexcept {
  const auto copy = [&](const std::array<std::uint8_t, 64>& prom, std::size_t first) {
    const QuadletView words(ByteView{prom.data(), prom.size()});
    for (std::size_t k = 0; k < out.size(); ++k) out.set(k, words[first + k]);
  };
  if ((where & 0xFF00) == address::kQlaPromData) return copy(qla_prom_, where & 0xFFU);
  if ((where >> 12) == 2) return copy(fpga_prom_, where & 0xFFFU);
  if ((where >> 12) == 6) {
    for (std::size_t k = 0; k < out.size(); ++k) out.set(k, dallas_quadlet((where & 0xFFFU) + k));
    return;
  }
  for (std::size_t k = 0; k < out.size(); ++k) out.set(k, 0);
  if ((where >> 12) == 8) {
    for (std::size_t k = 0; k < out.size(); ++k)
      out.set(k, read(static_cast<std::uint16_t>(where + k)));
  }
  if ((where >> 12) != 0) return;
  // Section 9: the address is a word index into the real-time block.
  std::array<std::uint8_t, 128> block{};
  const std::size_t quadlets = read_quadlets(setup_.firmware);
  encode_feedback(latch(), setup_.firmware, QuadletSpan({block.data(), 4 * quadlets}));
  const QuadletView words(ByteView{block.data(), 4 * quadlets});
  for (std::size_t k = 0; k < out.size(); ++k) out.set(k, words[where + k]);
}

}  // namespace veridyn::dvrk
