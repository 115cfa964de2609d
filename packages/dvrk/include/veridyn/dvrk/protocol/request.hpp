#pragma once

#include <cstddef>
#include <cstdint>

#include "veridyn/dvrk/protocol/bytes.hpp"
#include "veridyn/dvrk/protocol/protocol.hpp"

namespace veridyn::dvrk {

/// Reason for which a datagram is no packet.
enum class Malformed {
  kNone,
  kLength,  ///< too short, or a length that contradicts its own fields
  kBus,     ///< destination bus is not 0x3FF
  kTcode    ///< the transaction code does not belong to the protocol
};


/// A packet from the PC to a board: specification 2 and 3.
struct Request {
  std::uint8_t flags = 0;       ///< kNoForward or 0
  std::uint8_t generation = 0;  ///< generation of the bus, as known to the host
  std::uint8_t node = 0;        ///< or kBroadcastNode
  std::uint8_t label = 0;       ///< 0..63; the reply echoes it
  Tcode tcode = Tcode::kQuadletRead;
  std::uint16_t source = kHostId;
  std::uint32_t address = 0;  ///< boards use the low 16 bits
  std::uint32_t data = 0;     ///< Data of a quadlet write
  std::uint16_t bytes = 0;    ///< Bytes of a block read; of a block write when decoded
  QuadletView block;          ///< Content of a block write; points into the datagram when decoded
  bool crc_right = true;      ///< set by decode: all CRCs of the packet
};

/// Length of the datagram that encode() makes, section 2.1.
std::size_t encoded_size(const Request& request) noexcept;

/// Writes the whole datagram, CRCs included. @returns its length; 0: `out` is too small, the block
/// is larger than kMaxBlockBytes, or the tcode is no request.
std::size_t encode(const Request& request, ByteSpan out) noexcept;

/// Decodes a datagram, without reading outside of it. Wrong CRCs are reported in the result (specification 2.4).
Malformed decode(ByteView datagram, Request& request) noexcept;

}  // namespace veridyn::dvrk
