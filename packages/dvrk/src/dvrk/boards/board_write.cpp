#include <algorithm>
#include <cmath>

#include "dvrk/boards/board_bus.hpp"

// Writes to the boards: real-time blocks, registers, and the switch-off command.

namespace veridyn::dvrk {
namespace {

constexpr int kWriteTries = 3;

}  // namespace

void BoardBus::store_written(Board& b) noexcept {
  for (size_t c = 0; c < kChannels; ++c) {
    if (!b.command.channel[c].valid) continue;
    b.before[c] = b.has_sent[c] ? b.sent[c] : b.command.channel[c].value;
    b.sent[c] = b.command.channel[c].value;
    b.has_sent[c] = true;
  }
  b.command = BoardCommand();
  b.command.board = static_cast<std::uint8_t>(b.info.id);
}

void BoardBus::write() noexcept {
  if (listens()) return;
  if (state_ != BusState::kRunning || exchange_.generation_changed()) {
    switch_off(Off::kAmps);
  } else {
    write_blocks();
  }
  for (Board& b : boards_) store_written(b);
}

void BoardBus::write_blocks() noexcept {
  const QuadletSpan all({block_.data(), block_.size()});
  const bool together = protocol_ != CycleProtocol::kSequential;
  std::size_t at = 0;
  bool sent = true;
  for (Board& b : boards_) {
    const int firmware = b.info.firmware;
    const std::size_t size = write_quadlets(firmware);
    const QuadletSpan block = all.part(at, size);
    encode_command(b.command, firmware, block);
    if (!together) sent = exchange_.write_block(route(b), address::kRealTime, block) && sent;
    if (firmware == 6)  // section 10.4: control does not travel with the block
      sent = exchange_.write(route(b), address::kStatus, control_word(b.command)) && sent;
    if (together) at += size;
  }
  if (together)
    sent =
        exchange_.write_block(broadcast_route(), address::kRealTime, QuadletView(all).part(0, at)) && sent;
  link_lost_ = !sent;
}

void BoardBus::switch_off(Off what) noexcept {
  if (listens()) return;
  const std::uint32_t word = control::kAmpsOff | (what == Off::kPower ? control::kPowerOff : 0U);
  const QuadletSpan all({block_.data(), block_.size()});
  std::size_t at = 0;
  bool known = true;
  for (Board& b : boards_) {
    known = known && b.info.firmware > 0;
    if (b.info.firmware == 0) continue;
    BoardCommand& c = b.command;
    c = BoardCommand();
    c.board = static_cast<std::uint8_t>(b.info.id);
    c.control = word;
    for (size_t k = 0; k < kChannels; ++k)
      c.channel[k] = {true, false, AmpRequest::kOff, 0, b.zero[k]};
    const std::size_t size = write_quadlets(b.info.firmware);
    encode_command(c, b.info.firmware, all.part(at, size));
    at += size;
  }
  bool sent = true;
  if (known && one_group())
    sent = exchange_.write_block(broadcast_route(), address::kRealTime, QuadletView(all).part(0, at));
  // Boards of mixed firmware have no common block, and the block of Rev 6 has no control word: the control
  // register of all boards is written.
  if (!known || !one_group() || boards_.front().info.firmware == 6)
    sent = exchange_.write(broadcast_route(), address::kStatus, word) && sent;
  link_lost_ = !sent;
  for (Board& b : boards_) store_written(b);
}

bool BoardBus::switch_off_by_register(int b, Off what) noexcept {
  if (listens()) return false;
  const std::uint32_t word = control::kAmpsOff | (what == Off::kPower ? control::kPowerOff : 0U);
  return write_register(b, address::kStatus, word);
}

// False while node numbers are unknown: a number may belong to another board.
bool BoardBus::nodes_known() const noexcept {
  return state_ == BusState::kRunning && !exchange_.generation_changed();
}

bool BoardBus::read_register(int b, std::uint16_t where, std::uint32_t& value) noexcept {
  return nodes_known() && exchange_.read(route(boards_[b]), where, options_.reply_timeout, value) ==
                              ReadResult::kOk;
}

bool BoardBus::write_register(int b, std::uint16_t where, std::uint32_t value) noexcept {
  if (listens() || !nodes_known()) return false;
  return exchange_.write(route(boards_[b]), where, value);
}

bool BoardBus::write_checked(int b, std::uint16_t where, std::uint32_t value) noexcept {
  for (int k = 0; k < kWriteTries; ++k) {
    std::uint32_t there = 0;
    if (write_register(b, where, value) && read_register(b, where, there) && there == value)
      return true;
  }
  note(Condition::kNotEffective, info(b).id, {}, where);
  return false;
}

bool BoardBus::set_watchdog(double seconds) noexcept {
  if (listens()) return false;
  const double counts = std::round(seconds * kTicksPerSecond / kWatchdogTicks);
  watchdog_counts_ = static_cast<std::uint32_t>(std::clamp(counts, 1.0, 65535.0));
  // The watchdog never gets its power-up value, so that a restarted board can be recognised.
  if (watchdog_counts_ == kWatchdogDefault) ++watchdog_counts_;
  bool all = true;
  for (int b = 0; b < boards(); ++b) {
    all = write_checked(b, address::kWatchdog, watchdog_counts_) && all;
    boards_[b].rebooted = false;
  }
  return all;
}

}  // namespace veridyn::dvrk
