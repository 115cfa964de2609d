#pragma once

#include <cstdint>


namespace veridyn::dvrk {

/// Data of the broadcast query's quadlet: specification 8.3.
constexpr std::uint32_t query_word(std::uint16_t sequence, std::uint16_t boards) {
  return (static_cast<std::uint32_t>(sequence) << 16) | boards;
}

/// The sequence number after this one: 1, 2, ..., 65535, 1, ...; never 0.
constexpr std::uint16_t next_sequence(std::uint16_t sequence) {
  return sequence == 0xFFFF ? std::uint16_t{1} : static_cast<std::uint16_t>(sequence + 1);
}

/// The quadlet before each board's block in the hub's memory: specification 8.3.
struct HubHeader {
  std::uint8_t quadlets = 0;       ///< Quadlets of the block with this header; Rev 8 on
  std::uint16_t sequence = 0;      ///< 16 bits for Rev 7, the low 8 from Rev 8 on
  bool mismatch = false;           ///< Rev 8 on: the board received another sequence number than the hub
  std::uint16_t update_ticks = 0;  ///< ticks from the query to the arrival of the block
};

std::uint32_t encode_hub_header(const HubHeader& header, int firmware) noexcept;
HubHeader decode_hub_header(std::uint32_t word, int firmware) noexcept;

/// True if a header answers the query with this sequence number.
bool answers(const HubHeader& header, std::uint16_t sequence, int firmware) noexcept;

/// The last quadlet of the hub's memory.
struct HubTiming {
  std::uint16_t read_start = 0;  ///< ticks since the query
  std::uint16_t read_end = 0;
};

std::uint32_t encode_hub_timing(const HubTiming& timing, int firmware) noexcept;

}  // namespace veridyn::dvrk
