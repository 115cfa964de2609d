#include <algorithm>

#include "dvrk/boards/board_bus.hpp"

// Single registers: those that change slowly, and real-time words for a client that only reads.

namespace veridyn::dvrk {

void BoardBus::poll_registers() noexcept {
  if (state_ != BusState::kRunning || exchange_.generation_changed()) return;
  for (Board& b : boards_) {
    if (!b.suspect || !b.valid) continue;
    b.suspect = false;
    return check_registers(b);
  }
  if (options_.housekeeping <= 0 || cycles_ % options_.housekeeping != 0) return;
  const long turn = cycles_ / options_.housekeeping;
  Board& b = boards_[static_cast<size_t>(turn) % boards_.size()];
  if (b.valid) check_registers(b);
}

// Rev 7 shows its commands only in registers (specification 17 #27). Reads one channel per call, and again if it
// differs, so that a write that the read has overtaken does not count as lost.
void BoardBus::check_written_commands() noexcept {
  if (state_ != BusState::kRunning || exchange_.generation_changed() || listens()) return;
  const std::size_t sockets = boards_.size() * kChannels;
  std::size_t turn = asked_channel_;
  for (std::size_t k = 0; k < sockets; ++k) {
    turn = (asked_channel_ + k) % sockets;
    const Board& b = boards_[turn / kChannels];
    if (b.info.firmware < 8 && b.valid && b.has_sent[turn % kChannels]) break;
  }
  Board& b = boards_[turn / kChannels];
  const std::size_t c = turn % kChannels;
  if (b.info.firmware >= 8 || !b.valid || !b.has_sent[c]) return;
  std::uint32_t value = 0;
  if (exchange_.read(route(b), address::of_channel(static_cast<int>(c), address::kDac),
                     options_.rescan_timeout, value) != ReadResult::kOk)
    return;
  const auto shown = static_cast<std::uint16_t>(value & 0xFFFF);
  const bool lost = shown != b.sent[c] && shown != b.before[c];
  b.lost_writes = lost ? b.lost_writes + 1 : 0;
  if (lost) note(Condition::kNotEffective, b.info.id, static_cast<int>(c), value);
  asked_channel_ = lost ? turn : turn + 1;
}

// A block that does not show a command may be an old one: the channel's register has the command then.
void BoardBus::read_back_command(Board& b, std::size_t c) noexcept {
  std::uint32_t value = 0;
  const auto channel = static_cast<int>(c);
  if (!listens() && exchange_.read(route(b), address::of_channel(channel, address::kDac), options_.rescan_timeout,
                                   value) == ReadResult::kOk) {
    const auto there = static_cast<std::uint16_t>(value & 0xFFFF);
    const bool arrived = there == b.sent[c] || there == b.before[c];
    b.unshown = arrived ? Condition::kOldReplies : Condition::kNotEffective;
  }
  note(b.unshown, b.info.id, channel, b.feedback.channel[c].motor.word);
}

// Detects a restarted board and errors of its Ethernet port: specification 17, #25 and #28.
void BoardBus::check_registers(Board& b) noexcept {
  std::uint32_t value = 0;
  const double timeout = options_.rescan_timeout;
  if (watchdog_counts_ != 0 &&
      exchange_.read(route(b), address::kWatchdog, timeout, value) == ReadResult::kOk &&
      (value & 0xFFFF) != watchdog_counts_) {
    b.rebooted = true;
    note(Condition::kRebooted, b.info.id, {}, value);
  }
  if (exchange_.read(route(b), address::kEthernet, timeout, value) == ReadResult::kOk &&
      (value >> 31) != 0 && (value & kEthernetErrors) != 0)
    note(Condition::kEthernet, b.info.id, {}, value);
}

// Reads words 1 to 31 of a real-time block, each from its register; the boards' time stamp has
// none.
bool BoardBus::read_words(Board& b, QuadletSpan words) noexcept {
  constexpr address::Offset kOffsets[] = {
      address::kAnalog,   address::kPosition, address::kPeriod,     address::kQuarter1,
      address::kQuarter5, address::kRunning,  address::kMotorStatus};
  constexpr std::uint16_t kBoard[] = {address::kStatus, address::kDigitalIn, address::kTemperature};
  const double passed = b.read_at ? std::max(0.0, link_.now() - *b.read_at) : 0.0;
  words.set(0, static_cast<std::uint32_t>(std::min(passed * kTicksPerSecond, 4e9)));
  for (std::size_t k = 1; k < words.size(); ++k) {
    const std::uint16_t where =
        k < 4 ? kBoard[k - 1]
              : address::of_channel(static_cast<int>(k % kChannels), kOffsets[k / kChannels - 1]);
    std::uint32_t value = 0;
    const ReadResult result = exchange_.read(route(b), where, options_.reply_timeout, value);
    if (result != ReadResult::kOk) {
      mark_lost_read(b, condition_of(result));
      if (result == ReadResult::kDropped && state_ == BusState::kRunning)
        begin_scan(Condition::kGenerationChanged);
      return false;
    }
    words.set(k, value);
  }
  return true;
}

void BoardBus::read_by_register() noexcept {
  for (Board& b : boards_) {
    if (state_ != BusState::kRunning) {
      mark_lost_read(b, Condition::kDropped);
      continue;
    }
    const double asked = link_.now();
    const QuadletSpan words({block_.data(), 4 * read_quadlets(b.info.firmware)});
    if (read_words(b, words)) accept_block(b, QuadletView(words), asked);
  }
}

std::string BoardBus::qla_serial(int b) {
  constexpr std::uint32_t kReadFromStart = 0xFE000000;
  constexpr std::uint32_t kQuadlets = 3;
  constexpr double kReading = 0.001;  // [s] duration of the board's access to its memory
  const std::string kPrefix = "QLA ";
  QuadletView block;
  if (!write_register(b, address::kQlaPromCommand, kReadFromStart | (kQuadlets - 1))) return "";
  link_.wait(kReading);
  if (exchange_.read_block(route(boards_[b]), address::kQlaPromData, kQuadlets,
                           options_.reply_timeout, block) != ReadResult::kOk)
    return "";
  std::string out;
  for (std::size_t k = 0; k < block.bytes().size && block.bytes().data[k] != 0xFF; ++k)
    out += static_cast<char>(block.bytes().data[k]);
  return out.rfind(kPrefix, 0) == 0 ? out.substr(kPrefix.size()) : "";
}

}  // namespace veridyn::dvrk
