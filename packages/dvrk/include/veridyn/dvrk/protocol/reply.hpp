#pragma once

#include <cstddef>
#include <cstdint>

#include "veridyn/dvrk/protocol/bytes.hpp"
#include "veridyn/dvrk/protocol/request.hpp"

namespace veridyn::dvrk {

/// The last 8 bytes of everything that a board sends: specification 4.3.
struct Trailer {
  std::uint8_t flags = 0;
  std::uint8_t generation = 0;
  std::uint8_t invalid_states = 0;
  std::uint8_t packet_errors = 0;
  std::uint16_t receive_ticks = 0;
  std::uint16_t total_ticks = 0;
};

/// A packet from a board to the PC: specification 4.
struct Reply {
  enum class Kind { kQuadlet, kBlock, kDropped };  ///< kDropped: only the trailer

  Kind kind = Kind::kQuadlet;
  std::uint16_t destination = kHostId;
  std::uint8_t label = 0;
  std::uint8_t node = 0;  ///< The node that answers
  std::uint8_t rcode = 0;
  std::uint32_t data = 0;        ///< Data of a quadlet
  QuadletView block;             ///< Content of a block; points into the datagram when decoded
  std::uint32_t header_crc = 0;  ///< 0 in the hub's own answers; of a quadlet: its CRC
  std::uint32_t data_crc = 0;
  bool crc_right = true;  ///< set by decode: every nonzero CRC is correct
  Trailer trailer;
};

enum class Crc { kZero, kReal };

/// @param crc  kZero as in the hub's own answers; kReal as in relayed replies.
/// @returns the length; 0 if `out` is too small.
std::size_t encode(const Reply& reply, Crc crc, ByteSpan out) noexcept;

/// Decodes a datagram, without reading outside of it.
Malformed decode(ByteView datagram, Reply& reply) noexcept;

}  // namespace veridyn::dvrk
