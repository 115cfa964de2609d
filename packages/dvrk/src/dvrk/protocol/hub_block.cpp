#include "dvrk/protocol/hub_block.hpp"

namespace veridyn::dvrk {
namespace {

constexpr std::uint32_t kTime14 = 0x3FFF;
constexpr std::uint32_t kTime15 = 0x7FFF;  // mask of the time in a hub header of Rev 9

}  // namespace

std::uint32_t encode_hub_header(const HubHeader& h, int firmware) noexcept {
  const std::uint32_t time = h.update_ticks & (firmware >= 9 ? kTime15 : kTime14);
  if (firmware < 8) return (static_cast<std::uint32_t>(h.sequence) << 16) | time;
  return (static_cast<std::uint32_t>(h.quadlets) << 24) |
         (static_cast<std::uint32_t>(h.sequence & 0xFF) << 16) | (h.mismatch ? 0x8000U : 0U) | time;
}

HubHeader decode_hub_header(std::uint32_t word, int firmware) noexcept {
  HubHeader h;
  h.update_ticks = static_cast<std::uint16_t>(word & (firmware >= 9 ? kTime15 : kTime14));
  if (firmware < 8) {
    h.sequence = static_cast<std::uint16_t>(word >> 16);
    return h;
  }
  h.quadlets = static_cast<std::uint8_t>(word >> 24);
  h.sequence = static_cast<std::uint16_t>((word >> 16) & 0xFF);
  h.mismatch = (word & 0x8000U) != 0;
  return h;
}

bool answers(const HubHeader& header, std::uint16_t sequence, int firmware) noexcept {
  if (firmware < 8) return header.sequence == sequence;
  return header.sequence == (sequence & 0xFF) && !header.mismatch;
}

std::uint32_t encode_hub_timing(const HubTiming& timing, int firmware) noexcept {
  const std::uint32_t mask = firmware >= 9 ? 0xFFFFU : kTime14;
  return ((timing.read_start & mask) << 16) | (timing.read_end & mask);
}

}  // namespace veridyn::dvrk
