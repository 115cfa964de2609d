#pragma once

#include <cstddef>
#include <cstdint>

namespace veridyn::dvrk {

// Numbers of the boards' protocol. Sections, here and elsewhere, are those of the firmware I/O specification.

// Datagrams: specification 1 and 2.
constexpr std::uint16_t kUdpPort = 1394;
constexpr int kMaxBoards = 16;  ///< ids of the rotary switch
constexpr int kChannels = 4;    ///< Channels of a QLA
constexpr std::uint8_t kBroadcastNode = 0x3F;
constexpr std::uint8_t kNoForward = 0x01;  ///< control flag
constexpr std::size_t kControlBytes = 2;   ///< number of control bytes in front of a request

// Packets: specification 3.
constexpr std::uint16_t kBusId = 0x3FF;
constexpr std::uint16_t kHostId = 0xFFD0;
constexpr std::uint8_t kLabels = 64;
enum class Tcode : std::uint8_t {
  kQuadletWrite = 0,
  kBlockWrite = 1,
  kQuadletRead = 4,
  kBlockRead = 5,
  kQuadletReply = 6,
  kBlockReply = 7
};
constexpr std::size_t kMaxDatagram = 2048;
constexpr std::size_t kMaxBlockBytes = kMaxDatagram - 24;
constexpr std::size_t kDatagramBuffer = kMaxDatagram + 64;  ///< holds every datagram, and more

// Flags of a trailer: specification 4.3.
constexpr std::size_t kTrailerBytes = 8;
constexpr std::uint8_t kFlagBusReset = 0x01;
constexpr std::uint8_t kFlagDropped = 0x02;
constexpr std::uint8_t kFlagInternalError = 0x04;
constexpr std::uint8_t kFlagProtocolError = 0x08;
constexpr std::uint8_t kFlagNoForward = 0x10;  ///< Rev 9: echo

// Registers: specification 7.
namespace address {
constexpr std::uint16_t kStatus = 0;
constexpr std::uint16_t kPhyRequest = 1;
constexpr std::uint16_t kPhyResult = 2;
constexpr std::uint16_t kWatchdog = 3;
constexpr std::uint16_t kHardware = 4;
constexpr std::uint16_t kTemperature = 5;
constexpr std::uint16_t kDigitalOut = 6;
constexpr std::uint16_t kFirmware = 7;
constexpr std::uint16_t kFpgaPromCommand = 8;
constexpr std::uint16_t kFpgaPromResult = 9;
constexpr std::uint16_t kDigitalIn = 10;
constexpr std::uint16_t kIpAddress = 11;
constexpr std::uint16_t kEthernet = 12;
constexpr std::uint16_t kDallas = 13;
constexpr std::uint16_t kGitDescription = 15;
constexpr std::uint16_t kRealTime = 0;  ///< block access
constexpr std::uint16_t kHub = 0x1000;
constexpr std::uint16_t kHubQuery = 0x1800;
constexpr std::uint16_t kFpgaPromData = 0x2000;
constexpr std::uint16_t kQlaPromCommand = 0x3000;
constexpr std::uint16_t kQlaPromData = 0x3100;

/// Offsets of a channel's registers, section 7.4.
enum Offset : std::uint16_t {
  kAnalog = 0,
  kDac = 1,
  kPreload = 4,
  kPosition = 5,
  kPeriod = 6,
  kQuarter1 = 7,
  kDoutTiming = 8,
  kQuarter5 = 9,
  kRunning = 10,
  kMotorConfig = 11,
  kMotorStatus = 12
};
/// @param channel  from 0.
constexpr std::uint16_t of_channel(int channel, Offset offset) {
  return static_cast<std::uint16_t>(((channel + 1) << 4) | offset);
}
}  // namespace address

constexpr std::size_t kDallasBytes = 2048;  ///< memory of an instrument's chip, a DS2505
constexpr std::uint32_t kHardwareQla1 = 0x514C4131;  ///< "QLA1", section 1
constexpr std::uint32_t kPreloadNever = 0x800000;    ///< section 7.4; also the counter's zero
constexpr double kTicksPerSecond = 49.152e6;
constexpr std::uint32_t kWatchdogTicks = 256;       ///< Clock ticks in one count of register 3
constexpr std::uint32_t kWatchdogDefault = 0x1680;  ///< 30 ms
constexpr std::uint32_t kMotorConfigDefault = 0x01780418;
constexpr std::uint32_t kEthernetHealthy = 0xA01C0000;
constexpr std::uint32_t kEthernetV3 = 0x40B0B0B0;  ///< Healthy, FPGA V3
/// Register 12: FPGA V3, whose two Ethernet ports may replace FireWire.
constexpr bool is_fpga_v3(std::uint32_t ethernet) {
  return (ethernet >> 30) == 1;
}
constexpr std::uint32_t kEthernetErrors = 0x1FC00000;  ///< bits 28 to 22; V2

// The control word: specification 7.3.
namespace control {
constexpr std::uint32_t kPowerOn = 0x000C0000;
constexpr std::uint32_t kPowerOff = 0x00080000;
constexpr std::uint32_t kRelayClose = 0x00030000;
constexpr std::uint32_t kRelayOpen = 0x00020000;
constexpr std::uint32_t kAmpsOn = 0x00000F0F;
constexpr std::uint32_t kAmpsOff = 0x00000F00;
constexpr std::uint32_t kReboot = 0x00300000;
constexpr std::uint32_t kRealTimeBits = 0x000FFFFF;  ///< bits with an effect in real-time writes of Rev 7 and 8
}  // namespace control

// Sizes of a QLA's blocks by firmware, in quadlets: specification 7.7 and 8.3.
constexpr bool firmware_supported(int firmware) {
  return firmware >= 6 && firmware <= 9;
}
constexpr std::size_t read_quadlets(int firmware) {
  return firmware >= 8 ? 32 : firmware == 7 ? 28 : 20;
}
constexpr std::size_t write_quadlets(int firmware) {
  return firmware >= 8 ? 6 : firmware == 7 ? 5 : 4;
}
constexpr std::size_t hub_quadlets(int firmware) {
  return 1 + read_quadlets(firmware);
}
/// Boards whose blocks may share one broadcast: 4-6, 7, 8-9 (specification 5 and 17 #11).
constexpr int firmware_group(int firmware) {
  return firmware >= 8 ? 8 : firmware == 7 ? 7 : 6;
}

/// The largest block that fits an Ethernet of this MTU, in bytes: specification 3.2.
constexpr std::size_t largest_read(std::size_t mtu) {
  const std::size_t whole = mtu - 28 - kTrailerBytes;
  return (whole < kMaxDatagram ? whole : kMaxDatagram) - 24;
}

// DAC word of zero current: specification 12.
constexpr std::uint16_t kZeroCurrent = 0x8000;

}  // namespace veridyn::dvrk
