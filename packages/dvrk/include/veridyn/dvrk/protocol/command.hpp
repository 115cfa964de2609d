#pragma once

#include <array>
#include <cstdint>

#include "veridyn/dvrk/protocol/bytes.hpp"
#include "veridyn/dvrk/protocol/protocol.hpp"

namespace veridyn::dvrk {

enum class AmpRequest : std::uint8_t { kKeep, kOff, kOn };

/// Command of one channel: specification 10.3. Value and mode take effect only if `valid`.
struct ChannelCommand {
  bool valid = false;
  bool collect = false;
  AmpRequest amp = AmpRequest::kKeep;  ///< Rev 8 on; older boards use the control word
  std::uint8_t mode = 0;               ///< 0 current, 1 voltage; Rev 8 on
  std::uint16_t value = 0;             ///< DAC bits; kZeroCurrent is zero current
};

/// One real-time block write: specification 10. The default changes nothing and keeps the watchdog alive.
struct BoardCommand {
  std::uint8_t board = 0;
  std::array<ChannelCommand, kChannels> channel;
  std::uint32_t control = 0;  ///< section 7.3
};

/// Writes write_quadlets(firmware) quadlets. For Rev 7 the amplifier requests of the channels go
/// into the control word; for Rev 6 the control word does not travel with the block.
void encode_command(const BoardCommand& command, int firmware, QuadletSpan out) noexcept;

/// Rev 7: the control word with the requests of the channels.
std::uint32_t control_word(const BoardCommand& command) noexcept;

/// Decodes the command of a single block. @returns false: too short, or (Rev 8 on) the length in its header
/// differs.
bool decode_command(QuadletView block, int firmware, BoardCommand& command) noexcept;

/// Finds the block of `board` in the concatenated blocks of several boards (specification 10.2) and
/// decodes it. @returns false: there is none, or a header before it is malformed.
bool find_command(QuadletView blocks, int board, int firmware, BoardCommand& command) noexcept;

}  // namespace veridyn::dvrk
