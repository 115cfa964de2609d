#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

namespace veridyn::dvrk {

/// Conditions that a client must detect, with the numbers of section 17 of the firmware I/O specification.
enum class Condition : std::uint8_t {
  kNoReply = 1,
  kWrongSize = 2,
  kDropped = 3,
  kGenerationChanged = 4,
  kBusReset = 5,
  kWrongHeader = 6,
  kStaleReply = 7,
  kWrongCrc = 8,
  kWrongBoard = 9,
  kWrongHardware = 10,
  kWrongFirmware = 11,
  kDuplicateBoard = 12,
  kStaleSequence = 13,
  kMissingBoard = 14,
  kWrongBlockSize = 15,
  kTooLarge = 16,
  kWatchdog = 17,
  kNoSupply = 18,
  kSupplyFault = 19,
  kRelayOpen = 20,
  kAmpOff = 21,
  kCurrentTrip = 22,
  kOutOfBounds = 23,
  kEncoder = 24,
  kRebooted = 25,
  kTimestamp = 26,
  kNotEffective = 27,
  kEthernet = 28,
  kNotSent = 29,
  kForeignSender = 30,
  // Section 17 lists the following under its number 23 as well; see number_in_section_17().
  kTemperature = 31,
  kPot = 32,
  // Section 17 does not list the following: they are reported as 1, 7 and 23.
  kLostReplies = 33,
  kOldReplies = 34,
  kStalled = 35
};

constexpr int kConditions = 35;

/// The number under which section 17 lists a condition.
int number_in_section_17(Condition condition);

/// A short description: "no reply in time".
const char* describe(Condition condition);

/// FaultEntry::value as text, in the unit of the condition: "71.5 deg C", "pot 0.02 V", "status
/// 0x46bf0000".
std::string describe_found(Condition condition, std::uint32_t value);

/// History of one condition.
struct FaultEntry {
  long count = 0;
  double last = 0.0;        ///< [s] time of the last one by the link's clock
  std::optional<int> board = {};    ///< id of the last one; nullopt: the bus
  std::optional<int> channel = {};  ///< channel from 0; nullopt: the whole board
  std::uint32_t value = 0;  ///< the last value found, see describe_found()
};

/// Counts of all conditions. note() does not allocate.
class FaultLog {
 public:
  /// Counts a condition and stores its time [s], board id, channel from 0 and value.
  void note(Condition condition, double now, std::optional<int> board = {}, std::optional<int> channel = {},
            std::uint32_t value = 0) noexcept;
  const FaultEntry& operator[](Condition condition) const;
  long count(Condition condition) const { return (*this)[condition].count; }
  void clear() noexcept { *this = FaultLog(); }

  /// Text: one line for each condition that occurred; empty if none did.
  std::string report() const;

 private:
  std::array<FaultEntry, kConditions> entries_;
};

}  // namespace veridyn::dvrk
