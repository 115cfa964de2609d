#include "dvrk/protocol/reply.hpp"

#include <cstring>

#include "dvrk/protocol/crc.hpp"

namespace veridyn::dvrk {
namespace {

constexpr std::size_t kQuadletReplyBytes = 28;  // section 4.1
constexpr std::size_t kBlockReplyBytes = 32;    // section 4.2, without its data

void put_trailer(const Trailer& trailer, std::uint8_t* at) noexcept {
  at[0] = trailer.flags;
  at[1] = trailer.generation;
  at[2] = trailer.invalid_states;
  at[3] = trailer.packet_errors;
  store_quadlet(at + 4, (static_cast<std::uint32_t>(trailer.receive_ticks) << 16) |
                            static_cast<std::uint32_t>(trailer.total_ticks));
}

Trailer trailer_at(const std::uint8_t* at) noexcept {
  const std::uint32_t ticks = load_quadlet(at + 4);
  return {at[0],
          at[1],
          at[2],
          at[3],
          static_cast<std::uint16_t>(ticks >> 16),
          static_cast<std::uint16_t>(ticks)};
}

void put_header(const Reply& reply, Tcode tcode, std::uint8_t* at) noexcept {
  store_quadlet(at, (static_cast<std::uint32_t>(reply.destination) << 16) |
                        (static_cast<std::uint32_t>(reply.label & 0x3F) << 10) |
                        (static_cast<std::uint32_t>(tcode) << 4));
  store_quadlet(at + 4, (static_cast<std::uint32_t>(kBusId) << 22) |
                            (static_cast<std::uint32_t>(reply.node & 0x3F) << 16) |
                            (static_cast<std::uint32_t>(reply.rcode & 0xF) << 12));
  store_quadlet(at + 8, 0);
}

bool is_valid_crc(std::uint32_t crc, ByteView over) noexcept {
  return crc == 0 || crc == crc32(over);
}

}  // namespace

std::size_t encode(const Reply& reply, Crc crc, ByteSpan out) noexcept {
  const bool real = crc == Crc::kReal;
  const ByteView block = reply.block.bytes();
  const std::size_t size = reply.kind == Reply::Kind::kDropped   ? kTrailerBytes
                           : reply.kind == Reply::Kind::kQuadlet ? kQuadletReplyBytes
                                                                 : kBlockReplyBytes + block.size;
  if (out.size < size) return 0;
  std::uint8_t* at = out.data;
  if (reply.kind == Reply::Kind::kQuadlet) {
    put_header(reply, Tcode::kQuadletReply, at);
    store_quadlet(at + 12, reply.data);
    store_quadlet(at + 16, real ? crc32({at, 16}) : 0);
  } else if (reply.kind == Reply::Kind::kBlock) {
    put_header(reply, Tcode::kBlockReply, at);
    store_quadlet(at + 12, static_cast<std::uint32_t>(block.size) << 16);
    store_quadlet(at + 16, real ? crc32({at, 16}) : 0);
    if (block.size > 0) std::memmove(at + 20, block.data, block.size);
    store_quadlet(at + 20 + block.size, real ? crc32({at + 20, block.size}) : 0);
  }
  put_trailer(reply.trailer, at + size - kTrailerBytes);
  return size;
}

Malformed decode(ByteView datagram, Reply& reply) noexcept {
  reply = Reply();
  const std::uint8_t* at = datagram.data;
  if (datagram.size == kTrailerBytes) {
    reply.kind = Reply::Kind::kDropped;
    reply.trailer = trailer_at(at);
    return Malformed::kNone;
  }
  if (datagram.size < kQuadletReplyBytes) return Malformed::kLength;
  const std::uint32_t q0 = load_quadlet(at);
  const std::uint32_t q1 = load_quadlet(at + 4);
  const auto tcode = static_cast<Tcode>((q0 >> 4) & 0xF);
  if (tcode != Tcode::kQuadletReply && tcode != Tcode::kBlockReply) return Malformed::kTcode;
  if ((q1 >> 22) != kBusId) return Malformed::kBus;
  reply.destination = static_cast<std::uint16_t>(q0 >> 16);
  reply.label = static_cast<std::uint8_t>((q0 >> 10) & 0x3F);
  reply.node = static_cast<std::uint8_t>((q1 >> 16) & 0x3F);
  reply.rcode = static_cast<std::uint8_t>((q1 >> 12) & 0xF);
  reply.header_crc = load_quadlet(at + 16);
  reply.crc_right = is_valid_crc(reply.header_crc, {at, 16});
  if (tcode == Tcode::kQuadletReply) {
    if (datagram.size != kQuadletReplyBytes) return Malformed::kLength;
    reply.data = load_quadlet(at + 12);
  } else {
    const std::size_t bytes = load_quadlet(at + 12) >> 16;
    if (bytes % 4 != 0 || datagram.size != kBlockReplyBytes + bytes) return Malformed::kLength;
    reply.kind = Reply::Kind::kBlock;
    reply.block = QuadletView({at + 20, bytes});
    reply.data_crc = load_quadlet(at + 20 + bytes);
    reply.crc_right = reply.crc_right && is_valid_crc(reply.data_crc, {at + 20, bytes});
  }
  reply.trailer = trailer_at(at + datagram.size - kTrailerBytes);
  return Malformed::kNone;
}

}  // namespace veridyn::dvrk
