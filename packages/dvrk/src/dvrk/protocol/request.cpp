#include "dvrk/protocol/request.hpp"

#include <cstring>

#include "dvrk/protocol/crc.hpp"

namespace veridyn::dvrk {
namespace {

constexpr std::size_t kHeaderBytes = 12;  // three quadlets, after the control bytes

bool is_request_code(Tcode tcode) {
  return tcode == Tcode::kQuadletWrite || tcode == Tcode::kBlockWrite ||
         tcode == Tcode::kQuadletRead || tcode == Tcode::kBlockRead;
}

// Appends quadlets and CRCs to a FireWire packet.
class Writer {
 public:
  explicit Writer(std::uint8_t* packet) : packet_(packet) {}
  void quadlet(std::uint32_t value) {
    store_quadlet(packet_ + at_, value);
    at_ += 4;
  }
  void block(ByteView bytes) {
    if (bytes.size > 0) std::memcpy(packet_ + at_, bytes.data, bytes.size);
    at_ += bytes.size;
  }
  void append_crc(std::size_t first) { quadlet(crc32({packet_ + first, at_ - first})); }
  std::size_t size() const { return at_; }

 private:
  std::uint8_t* packet_;
  std::size_t at_ = 0;
};

bool crc_at(const std::uint8_t* packet, std::size_t first, std::size_t at) {
  return crc32({packet + first, at - first}) == load_quadlet(packet + at);
}

// Body of a block write; `packet` and `size` without the control bytes.
Malformed decode_block_write(const std::uint8_t* packet, std::size_t size, Request& r) noexcept {
  if (size < 24) return Malformed::kLength;
  const std::uint32_t bytes = load_quadlet(packet + 12) >> 16;
  if (bytes % 4 != 0 || size != 24 + static_cast<std::size_t>(bytes)) return Malformed::kLength;
  r.bytes = static_cast<std::uint16_t>(bytes);
  r.block = QuadletView({packet + 20, bytes});
  r.crc_right = crc_at(packet, 0, 16) && crc_at(packet, 20, 20 + bytes);
  return Malformed::kNone;
}

Malformed decode_body(const std::uint8_t* packet, std::size_t size, Request& r) noexcept {
  switch (r.tcode) {
    case Tcode::kQuadletRead:
      if (size != 16) return Malformed::kLength;
      r.crc_right = crc_at(packet, 0, 12);
      return Malformed::kNone;
    case Tcode::kQuadletWrite:
      if (size != 20) return Malformed::kLength;
      r.data = load_quadlet(packet + 12);
      r.crc_right = crc_at(packet, 0, 16);
      return Malformed::kNone;
    case Tcode::kBlockRead:
      if (size != 20) return Malformed::kLength;
      r.bytes = static_cast<std::uint16_t>(load_quadlet(packet + 12) >> 16);
      if (r.bytes % 4 != 0) return Malformed::kLength;
      r.crc_right = crc_at(packet, 0, 16);
      return Malformed::kNone;
    case Tcode::kBlockWrite:
      return decode_block_write(packet, size, r);
    default:
      return Malformed::kTcode;
  }
}

}  // namespace

std::size_t encoded_size(const Request& request) noexcept {
  switch (request.tcode) {
    case Tcode::kQuadletWrite:
      return 22;
    case Tcode::kBlockWrite:
      return 26 + request.block.bytes().size;
    case Tcode::kQuadletRead:
      return 18;
    case Tcode::kBlockRead:
      return 22;
    default:
      return 0;
  }
}

std::size_t encode(const Request& request, ByteSpan out) noexcept {
  const ByteView block = request.block.bytes();
  const bool writes_block = request.tcode == Tcode::kBlockWrite;
  if (!is_request_code(request.tcode) || out.size < encoded_size(request)) return 0;
  if (writes_block && (block.size > kMaxBlockBytes || block.size % 4 != 0)) return 0;
  out.data[0] = request.flags;
  out.data[1] = request.generation;
  Writer packet(out.data + kControlBytes);
  packet.quadlet((static_cast<std::uint32_t>(kBusId) << 22) |
                 (static_cast<std::uint32_t>(request.node & 0x3F) << 16) |
                 (static_cast<std::uint32_t>(request.label & 0x3F) << 10) |
                 (static_cast<std::uint32_t>(request.tcode) << 4));
  packet.quadlet(static_cast<std::uint32_t>(request.source) << 16);
  packet.quadlet(request.address);
  if (request.tcode == Tcode::kQuadletWrite) packet.quadlet(request.data);
  if (request.tcode == Tcode::kBlockRead)
    packet.quadlet(static_cast<std::uint32_t>(request.bytes) << 16);
  if (writes_block) packet.quadlet(static_cast<std::uint32_t>(block.size) << 16);
  packet.append_crc(0);
  if (writes_block) {
    const std::size_t first = packet.size();
    packet.block(block);
    packet.append_crc(first);
  }
  return kControlBytes + packet.size();
}

Malformed decode(ByteView datagram, Request& request) noexcept {
  if (datagram.size < kControlBytes + kHeaderBytes + 4) return Malformed::kLength;
  const std::uint8_t* packet = datagram.data + kControlBytes;
  const std::uint32_t q0 = load_quadlet(packet);
  if ((q0 >> 22) != kBusId) return Malformed::kBus;
  request = Request();
  request.flags = datagram.data[0];
  request.generation = datagram.data[1];
  request.node = static_cast<std::uint8_t>((q0 >> 16) & 0x3F);
  request.label = static_cast<std::uint8_t>((q0 >> 10) & 0x3F);
  request.tcode = static_cast<Tcode>((q0 >> 4) & 0xF);
  request.source = static_cast<std::uint16_t>(load_quadlet(packet + 4) >> 16);
  request.address = load_quadlet(packet + 8);
  return decode_body(packet, datagram.size - kControlBytes, request);
}

}  // namespace veridyn::dvrk
