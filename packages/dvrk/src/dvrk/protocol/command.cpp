#include "dvrk/protocol/command.hpp"

namespace veridyn::dvrk {
namespace {

// The word of a channel in a block write from Rev 8 on: specification 10.3.
std::uint32_t dac_word(const ChannelCommand& c) noexcept {
  const std::uint32_t amp = c.amp == AmpRequest::kOn    ? 0x30000000U
                            : c.amp == AmpRequest::kOff ? 0x20000000U
                                                        : 0U;
  return (c.valid ? 0x80000000U : 0U) | (c.collect ? 0x40000000U : 0U) | amp |
         (static_cast<std::uint32_t>(c.mode & 0xF) << 24) | c.value;
}

ChannelCommand channel_of(std::uint32_t word) noexcept {
  ChannelCommand c;
  c.valid = (word & 0x80000000U) != 0;
  c.collect = (word & 0x40000000U) != 0;
  if ((word & 0x20000000U) != 0)
    c.amp = (word & 0x10000000U) != 0 ? AmpRequest::kOn : AmpRequest::kOff;
  c.mode = static_cast<std::uint8_t>((word >> 24) & 0xF);
  c.value = static_cast<std::uint16_t>(word);
  return c;
}

// The word of a DAC for Rev 7, where bits 27:24 hold the board id instead of amplifier and mode: specification 10.4.
std::uint32_t dac_word_rev7(const ChannelCommand& c, std::uint8_t board) noexcept {
  return (c.valid ? 0x80000000U : 0U) | (c.collect ? 0x40000000U : 0U) |
         (static_cast<std::uint32_t>(board & 0xF) << 24) | c.value;
}

ChannelCommand channel_of_rev7(std::uint32_t word) noexcept {
  ChannelCommand c;
  c.valid = (word & 0x80000000U) != 0;
  c.collect = (word & 0x40000000U) != 0;
  c.value = static_cast<std::uint16_t>(word);
  return c;
}

bool decode_rev8(QuadletView block, BoardCommand& command) noexcept {
  const std::size_t quadlets = write_quadlets(8);
  if (block.size() < quadlets || (block[0] & 0xFF) != quadlets) return false;
  command = BoardCommand();
  command.board = static_cast<std::uint8_t>((block[0] >> 8) & 0xF);
  for (std::size_t k = 0; k < kChannels; ++k) command.channel[k] = channel_of(block[1 + k]);
  command.control = block[5];
  return true;
}

// A board uses the quadlets with its own id, and the control word (Rev 7) only if all four have this id:
// section 10.4.
bool find_rev7(QuadletView blocks, int board, int firmware, BoardCommand& command) noexcept {
  const std::size_t quadlets = write_quadlets(firmware);
  bool found = false;
  for (std::size_t first = 0; first + quadlets <= blocks.size(); first += quadlets) {
    std::size_t mine = 0;
    BoardCommand here;
    for (std::size_t k = 0; k < kChannels; ++k) {
      const std::uint32_t word = blocks[first + k];
      if (static_cast<int>((word >> 24) & 0xF) != board) continue;
      here.channel[k] = channel_of_rev7(word);
      ++mine;
    }
    if (mine == 0) continue;
    if (mine == kChannels && firmware >= 7)
      here.control = blocks[first + kChannels] & control::kRealTimeBits;
    here.board = static_cast<std::uint8_t>(board);
    command = here;
    found = true;
  }
  return found;
}

}  // namespace

std::uint32_t control_word(const BoardCommand& command) noexcept {
  std::uint32_t word = command.control;
  for (int k = 0; k < kChannels; ++k) {
    const AmpRequest amp = command.channel[k].amp;
    if (amp == AmpRequest::kKeep) continue;
    word |= 1U << (8 + k);
    word &= ~(1U << k);
    if (amp == AmpRequest::kOn) word |= 1U << k;
  }
  return word;
}

void encode_command(const BoardCommand& command, int firmware, QuadletSpan out) noexcept {
  if (firmware >= 8) {
    out.set(0, static_cast<std::uint32_t>((command.board & 0xF) << 8 | write_quadlets(firmware)));
    for (std::size_t k = 0; k < kChannels; ++k) out.set(1 + k, dac_word(command.channel[k]));
    out.set(5, command.control);
    return;
  }
  for (std::size_t k = 0; k < kChannels; ++k)
    out.set(k, dac_word_rev7(command.channel[k], command.board));
  if (firmware == 7) out.set(kChannels, control_word(command));
}

bool decode_command(QuadletView block, int firmware, BoardCommand& command) noexcept {
  if (firmware >= 8) return decode_rev8(block, command);
  if (block.size() < write_quadlets(firmware)) return false;
  return find_rev7(block.part(0, write_quadlets(firmware)),
                   static_cast<int>((block[0] >> 24) & 0xF), firmware, command);
}

bool find_command(QuadletView blocks, int board, int firmware, BoardCommand& command) noexcept {
  if (firmware < 8) return find_rev7(blocks, board, firmware, command);
  for (std::size_t first = 0; first < blocks.size();) {
    const std::uint32_t header = blocks[first];
    const std::size_t quadlets = header & 0xFF;
    if (quadlets == 0 || first + quadlets > blocks.size()) return false;  // section 10.2
    if (static_cast<int>((header >> 8) & 0xF) == board)
      return decode_rev8(blocks.part(first, quadlets), command);
    first += quadlets;
  }
  return false;
}

}  // namespace veridyn::dvrk
