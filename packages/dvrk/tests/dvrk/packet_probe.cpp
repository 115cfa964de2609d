#include "dvrk/packet_probe.hpp"

#include <array>
#include <cstring>

#include "dvrk/protocol/command.hpp"
#include "dvrk/protocol/feedback.hpp"
#include "dvrk/protocol/hub_block.hpp"
#include "dvrk/protocol/reply.hpp"
#include "dvrk/protocol/request.hpp"

namespace veridyn::dvrk {
namespace {

using Buffer = std::array<std::uint8_t, 2 * kDatagramBuffer>;

// Fields that encode() always writes as zero: retry, priority, the high half of the address.
bool has_canonical_header(ByteView d) {
  return (load_quadlet(d.data + 2) & 0x30FU) == 0 && (load_quadlet(d.data + 6) & 0xFFFFU) == 0;
}

bool has_canonical_lengths(ByteView d, const Request& r) {
  const bool block = r.tcode == Tcode::kBlockRead || r.tcode == Tcode::kBlockWrite;
  return !block || (load_quadlet(d.data + 14) & 0xFFFFU) == 0;
}

const char* probe_blocks(QuadletView block) {
  for (const int firmware : {6, 7, 8, 9}) {
    BoardCommand command;
    if (decode_command(block, firmware, command)) {
      std::array<std::uint8_t, 24> again{};
      encode_command(command, firmware, QuadletSpan({again.data(), again.size()}));
      BoardCommand same;
      const QuadletView written({again.data(), 4 * write_quadlets(firmware)});
      if (!decode_command(written, firmware, same)) return "a command that is lost when encoded";
      if (same.control != command.control || same.board != command.board)
        return "a command that changes when encoded";
    }
    for (int board = 0; board < kMaxBoards; ++board) find_command(block, board, firmware, command);
    const BoardFeedback f = decode_feedback(block, firmware);
    for (const ChannelFeedback& c : f.channel) encoder_motion(c.encoder);
    if (block.size() >= read_quadlets(firmware)) {
      std::array<std::uint8_t, 128> again{};
      encode_feedback(f, firmware, QuadletSpan({again.data(), again.size()}));
      if (std::memcmp(again.data(), block.bytes().data, 4 * read_quadlets(firmware)) != 0)
        return "feedback that changes when encoded";
    }
    decode_hub_header(block[0], firmware);
  }
  return nullptr;
}

const char* probe_request(ByteView d) {
  Request r;
  if (decode(d, r) != Malformed::kNone) return nullptr;
  if (const char* wrong = probe_blocks(r.block)) return wrong;
  Buffer buffer;
  const std::size_t size = encode(r, {buffer.data(), buffer.size()});
  if (r.tcode == Tcode::kBlockWrite && r.block.bytes().size > kMaxBlockBytes)
    return size == 0 ? nullptr : "a block beyond the limit that is encoded";
  if (size != d.size) return "a request of another length when encoded";
  if (r.crc_right && has_canonical_header(d) && has_canonical_lengths(d, r) &&
      std::memcmp(buffer.data(), d.data, size) != 0)
    return "a request that changes when encoded";
  return nullptr;
}

const char* probe_reply(ByteView d) {
  Reply r;
  if (decode(d, r) != Malformed::kNone) return nullptr;
  if (const char* wrong = probe_blocks(r.block)) return wrong;
  if (d.size > kDatagramBuffer) return nullptr;
  Buffer buffer;
  const std::size_t size = encode(r, Crc::kZero, {buffer.data(), buffer.size()});
  if (size != d.size) return "a reply of another length when encoded";
  Reply same;
  if (decode({buffer.data(), size}, same) != Malformed::kNone) return "an encoded reply is lost";
  if (same.label != r.label || same.node != r.node || same.data != r.data ||
      same.block.size() != r.block.size() || same.trailer.generation != r.trailer.generation)
    return "a reply that changes when encoded";
  return nullptr;
}

}  // namespace

const char* probe_packet(ByteView datagram) {
  if (const char* wrong = probe_request(datagram)) return wrong;
  return probe_reply(datagram);
}

}  // namespace veridyn::dvrk
