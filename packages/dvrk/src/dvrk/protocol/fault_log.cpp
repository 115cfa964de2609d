#include "dvrk/protocol/fault_log.hpp"

#include <iomanip>

#include "dvrk/protocol/analog.hpp"
#include "dvrk/protocol/protocol.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/math/text_stream.hpp"

namespace veridyn::dvrk {

const char* describe(Condition condition) {
  switch (condition) {
    case Condition::kNoReply:
      return "no reply in time";
    case Condition::kWrongSize:
      return "a reply of the wrong size";
    case Condition::kDropped:
      return "a read was dropped by the board";
    case Condition::kGenerationChanged:
      return "the bus generation has changed";
    case Condition::kBusReset:
      return "a bus reset is under way";
    case Condition::kWrongHeader:
      return "a reply that does not fit its request";
    case Condition::kStaleReply:
      return "an unsolicited reply";
    case Condition::kWrongCrc:
      return "a reply with a wrong CRC";
    case Condition::kWrongBoard:
      return "another board than expected";
    case Condition::kWrongHardware:
      return "hardware that cannot be driven";
    case Condition::kWrongFirmware:
      return "unsupported or mixed firmware";
    case Condition::kDuplicateBoard:
      return "a board id on two nodes";
    case Condition::kStaleSequence:
      return "an old block in the broadcast read";
    case Condition::kMissingBoard:
      return "a board is missing";
    case Condition::kWrongBlockSize:
      return "a block of the wrong size in the broadcast read";
    case Condition::kTooLarge:
      return "a broadcast read that is too large for the network";
    case Condition::kWatchdog:
      return "the watchdog has tripped";
    case Condition::kNoSupply:
      return "no motor supply: emergency stop, or the supply is off";
    case Condition::kSupplyFault:
      return "fault of the motor supply";
    case Condition::kRelayOpen:
      return "the safety relay is open";
    case Condition::kAmpOff:
      return "an amplifier is off that should be on";
    case Condition::kCurrentTrip:
      return "the board's current check has tripped";
    case Condition::kOutOfBounds:
      return "a motor current out of bounds";
    case Condition::kEncoder:
      return "an encoder cannot be trusted";
    case Condition::kRebooted:
      return "a board was rebooted";
    case Condition::kTimestamp:
      return "an implausible timestamp: missed cycles";
    case Condition::kNotEffective:
      return "a write had no effect";
    case Condition::kEthernet:
      return "Ethernet errors on the board";
    case Condition::kNotSent:
      return "sending failed";
    case Condition::kForeignSender:
      return "a datagram from elsewhere";
    case Condition::kTemperature:
      return "a board is too warm, or its temperature is not known";
    case Condition::kPot:
      return "a pot disagrees with its encoder";
    case Condition::kLostReplies:
      return "lost or late replies";
    case Condition::kOldReplies:
      return "old replies in the place of new ones";
    case Condition::kStalled:
      return "a motor at its largest current that does not move: an end stop, an obstacle or a brake";
  }
  return "";
}

int number_in_section_17(Condition condition) {
  switch (condition) {
    case Condition::kLostReplies:
      return static_cast<int>(Condition::kNoReply);
    case Condition::kOldReplies:
      return static_cast<int>(Condition::kStaleReply);
    case Condition::kTemperature:
    case Condition::kPot:
    case Condition::kStalled:
      return static_cast<int>(Condition::kOutOfBounds);
    default:
      return static_cast<int>(condition);
  }
}

std::string describe_found(Condition condition, std::uint32_t value) {
  const auto celsius = [](std::uint32_t half_degrees) {
    return half_degrees == 0xFF ? std::string("none") : text(0.5 * half_degrees, " deg C");
  };
  TextStream out;
  switch (condition) {
    case Condition::kTemperature:
      out << celsius((value >> 8) & 0xFF) << " and " << celsius(value & 0xFF);
      break;
    case Condition::kPot:
      out << std::setprecision(3) << value * 4.5 / 65536 << " V of 4.5 V";
      break;
    case Condition::kOutOfBounds:
    case Condition::kStalled:
      out << std::setprecision(3) << kNominalBitsToAmps(value) << " A before calibration";
      break;
    case Condition::kTimestamp:
      out << std::setprecision(3) << 1e3 * (value + 1.0) / kTicksPerSecond << " ms";
      break;
    case Condition::kWrongSize:
    case Condition::kStaleReply:
    case Condition::kTooLarge:
      out << value << " bytes";
      break;
    default:
      out << "0x" << std::hex << value;
  }
  return out.str();
}

void FaultLog::note(Condition condition, double now, std::optional<int> board, std::optional<int> channel,
                    std::uint32_t value) noexcept {
  FaultEntry& entry = entries_[static_cast<std::size_t>(condition) - 1];
  entry = {entry.count + 1, now, board, channel, value};
}

const FaultEntry& FaultLog::operator[](Condition condition) const {
  return entries_[static_cast<std::size_t>(condition) - 1];
}

std::string FaultLog::report() const {
  TextStream out;
  for (int k = 1; k <= kConditions; ++k) {
    const auto condition = static_cast<Condition>(k);
    const FaultEntry& entry = (*this)[condition];
    if (entry.count == 0) continue;
    out << describe(condition) << " (" << entry.count << " times";
    if (entry.board) out << ", board " << *entry.board;
    if (entry.channel) out << ", channel " << *entry.channel + 1;
    out << ", found " << describe_found(condition, entry.value) << ")\n";
  }
  return out.str();
}

}  // namespace veridyn::dvrk
