#include "emulator/board_emulator.hpp"

#include <algorithm>
#include <set>

#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

constexpr double kLongestStep = 0.002;  // [s] longest integration step of the load

}  // namespace

BoardEmulator::BoardEmulator(const std::vector<BoardSetup>& boards, std::uint8_t generation)
    : generation_(generation) {
  require(!boards.empty() && boards.size() <= kMaxBoards, "board emulator: found ", boards.size(),
          " boards, expected 1 to 16.");
  std::set<int> ids;
  for (const BoardSetup& setup : boards) {
    require(setup.id >= 0 && setup.id < kMaxBoards, "board emulator: found board id ", setup.id,
            ", expected 0 to 15.");
    require(firmware_supported(setup.firmware), "board emulator: found firmware ", setup.firmware,
            " for board ", setup.id, ", expected 6 to 9.");
    require(ids.insert(setup.id).second, "board emulator: found board id ", setup.id, " twice.");
    nodes_.push_back(static_cast<int>(nodes_.size()));
    by_id_.push_back(static_cast<int>(by_id_.size()));
    boards_.emplace_back(setup);
  }
  std::sort(by_id_.begin(), by_id_.end(),
            [&](int a, int b) { return board(a).setup().id < board(b).setup().id; });
  drives_.resize(boards_.size() * kChannels);
  motions_.resize(boards_.size() * kChannels);
  slots_.resize(boards_.size());
}

void BoardEmulator::attach(BoardLoad* load) {
  load_ = load;
  load_or_none().advance(0.0, drives_.data(), motions_.data(), drives_.size());
  for (int b = 0; b < boards(); ++b) {
    for (int c = 0; c < kChannels; ++c) {
      const ChannelMotion& motion = motions_[kChannels * b + c];
      board(b).set_motion(c, motion);
      board(b).encoder(c).power_up(motion.counts, now_);
    }
  }
}

void BoardEmulator::bus_reset(double seconds, const std::vector<int>& nodes) {
  ++generation_;
  reset_until_ = now_ + static_cast<Ticks>(seconds * kTicksPerSecond);
  if (!nodes.empty()) nodes_ = nodes;
}

void BoardEmulator::reboot(int place) {
  board(place).reboot(now_);
  bus_reset();
}

void BoardEmulator::advance(Ticks now) noexcept {
  if (!started_) {
    started_ = true;
    now_ = now;
    for (EmulatedBoard& b : boards_) b.reboot(now);
  }
  while (now_ < now) {
    const Ticks step = std::min(now - now_, static_cast<Ticks>(kLongestStep * kTicksPerSecond));
    now_ += step;
    for (int k = 0; k < boards() * kChannels; ++k)
      drives_[k] = board(k / kChannels).drive(k % kChannels);
    load_or_none().advance(static_cast<double>(step) / kTicksPerSecond, drives_.data(),
                           motions_.data(), drives_.size());
    chain.relays_closed = std::all_of(boards_.begin(), boards_.end(),
                                      [](const EmulatedBoard& b) { return b.relay_closed(); });
    for (int b = 0; b < boards(); ++b) {
      board(b).advance(now_, chain);
      for (int c = 0; c < kChannels; ++c)
        board(b).set_motion(c, motions_[kChannels * b + c]);
      if (board(b).reboot_requested) reboot(b);
    }
  }
}

void BoardEmulator::without_firewire() noexcept {
  ethernet_only_ = true;
  for (EmulatedBoard& b : boards_) b.ethernet = kEthernetV3;
}

int BoardEmulator::place_of(int node) const noexcept {
  const auto found = std::find(nodes_.begin(), nodes_.end(), node);
  return found == nodes_.end() ? -1 : static_cast<int>(found - nodes_.begin());
}

Answer BoardEmulator::handle(ByteView datagram, Ticks now, ByteSpan reply) noexcept {
  advance(now);
  if (is_lost()) return {};
  ++counters_.requests;
  Request request;
  if (decode(datagram, request) != Malformed::kNone) {
    ++counters_.malformed;
    return {};
  }
  if (!request.crc_right) ++counters_.wrong_crc;
  const Answer answer = execute(request, reply);
  return answer.size > 0 && is_lost() ? Answer() : answer;
}

bool BoardEmulator::is_lost() noexcept {
  if (faults.loss <= 0.0) return false;
  fate_ ^= fate_ << 13;
  fate_ ^= fate_ >> 7;
  fate_ ^= fate_ << 17;
  return static_cast<double>(fate_ >> 11) * 0x1p-53 < faults.loss;
}

// Executes or drops a request, depending on generation and bus reset: specification 2.4.
Answer BoardEmulator::execute(const Request& request, ByteSpan reply) noexcept {
  const bool reads = request.tcode == Tcode::kQuadletRead || request.tcode == Tcode::kBlockRead;
  const bool broadcast = request.node == kBroadcastNode;
  const bool exempt = board(hub()).setup().firmware >= 9 && (request.flags & kNoForward) != 0;
  echo_ = exempt ? kFlagNoForward : std::uint8_t{0};
  const bool stale = !broadcast && request.generation != generation_;
  if (!exempt && (resetting() || stale)) {
    ++counters_.dropped;
    if (!reads) return {};
    Reply dropped;
    dropped.kind = Reply::Kind::kDropped;
    const std::uint8_t reset = resetting() ? kFlagBusReset : std::uint8_t{0};
    dropped.trailer = trailer(static_cast<std::uint8_t>(kFlagDropped | reset));
    return {encode(dropped, Crc::kZero, reply), 0.0, false};
  }
  if (!reads) {
    ++counters_.writes;
    if (faults.lose_writes) return {};
    write(request);
    const bool query = request.node == kBroadcastNode && request.tcode == Tcode::kQuadletWrite &&
                       (request.address & 0xFFFF) == address::kHubQuery;
    return ethernet_only_ && exempt && query ? answer_query(request, reply) : Answer();
  }
  const int place = requesting_reader(request);
  return place < 0 ? Answer() : read(request, place, reply);
}

// Index of the board that executes a request to one node; -1: none. The hub executes a request despite a wrong
// CRC, but does not forward it to other boards (specification 2.4).
int BoardEmulator::requesting_reader(const Request& request) const noexcept {
  const bool local = (request.flags & kNoForward) != 0;
  const BoardSetup& its = boards_[hub()].setup();
  const bool by_id = local && its.firmware >= 9;
  if (ethernet_only_) {
    if (!local) return -1;  // no board answers behind the hub
    if (request.node == kBroadcastNode) return hub();
    const auto own = std::find_if(boards_.begin(), boards_.end(), [&](const EmulatedBoard& b) {
      return b.setup().id == request.node;
    });
    return own == boards_.end() ? -1 : static_cast<int>(own - boards_.begin());
  }
  if (request.node == kBroadcastNode) return local || its.firmware < 9 ? hub() : -1;
  if (by_id) return request.node == its.id ? hub() : -1;
  const int place = place_of(request.node);
  const bool arrives = place == hub() || (!local && request.crc_right);
  return arrives ? place : -1;
}

void BoardEmulator::write(const Request& request) noexcept {
  const bool forwards = (request.flags & kNoForward) == 0 && request.crc_right;
  if (request.node != kBroadcastNode) {
    const int place = requesting_reader(request);
    if (place >= 0) write_to(board(place), request);
    return;
  }
  for (int b = 0; b < boards(); ++b) {
    if (b == hub() || forwards || ethernet_only_) write_to(board(b), request);
  }
  if (request.tcode == Tcode::kQuadletWrite && (request.address & 0xFFFF) == address::kHubQuery)
    start_query(request.data);
}

void BoardEmulator::write_to(EmulatedBoard& b, const Request& request) noexcept {
  const auto where = static_cast<std::uint16_t>(request.address);
  if (request.tcode == Tcode::kBlockWrite) {
    b.write_block(where, request.block);
    return;
  }
  b.write(where, request.data);
  if (where == address::kPhyRequest) {  // register 0: node id; register 1: gap count
    const std::uint32_t number = request.data & 0xF;
    const int place = static_cast<int>(&b - boards_.data());
    if ((request.data & 0x1F00) == 0x1100) gap_count_ = request.data & 0x3F;
    b.phy_result = (number << 8) | (number == 0   ? static_cast<std::uint32_t>(node_of(place)) << 2
                                    : number == 1 ? gap_count_
                                                  : 0U);
  }
  if (b.reboot_requested) reboot(static_cast<int>(&b - boards_.data()));
}

// Without FireWire the first board answers a query with the blocks of all boards: specification 8.5.
Answer BoardEmulator::answer_query(const Request& query, ByteSpan out) noexcept {
  std::size_t quadlets = 1;
  for (HubSlot& slot : slots_) slot.at = now_;
  for (const EmulatedBoard& b : boards_) {
    if (((query_ >> b.setup().id) & 1U) != 0) quadlets += hub_quadlets(b.setup().firmware);
  }
  Request block = query;
  block.tcode = Tcode::kBlockRead;
  block.address = address::kHub;
  block.bytes = static_cast<std::uint16_t>(4 * quadlets);
  return read(block, hub(), out);
}

Answer BoardEmulator::read(const Request& request, int place, ByteSpan out) noexcept {
  Reply reply;
  reply.destination = request.source;
  reply.label = request.label;
  // Rev 9 answers requests to itself alone with its board id (specification 4.2).
  reply.node = static_cast<std::uint8_t>(echo_ != 0 ? board(place).setup().id : node_of(place));
  reply.trailer = trailer(0);
  const auto where = static_cast<std::uint16_t>(request.address);
  if (request.tcode == Tcode::kQuadletRead) {
    reply.data = board(place).read(where);
  } else {
    if (request.bytes > kMaxBlockBytes) return {};
    const ByteSpan bytes{block_.data(), request.bytes};
    read_block(request, place, QuadletSpan(bytes));
    reply.kind = Reply::Kind::kBlock;
    reply.block = QuadletView(bytes);
  }
  return send(reply, place, out);
}

void BoardEmulator::read_block(const Request& request, int place, QuadletSpan out) noexcept {
  const auto where = static_cast<std::uint16_t>(request.address);
  if ((where & 0xF800) == address::kHub) {
    read_hub(out);
  } else {
    board(place).read_block(where, out);
  }
}

Trailer BoardEmulator::trailer(std::uint8_t flags) const noexcept {
  Trailer t;
  t.flags = static_cast<std::uint8_t>(flags | faults.flags | echo_);
  t.generation = static_cast<std::uint8_t>(generation_ + faults.generation_ahead);
  t.packet_errors = faults.packet_errors;
  t.receive_ticks = receive_ticks;
  t.total_ticks = total_ticks;
  return t;
}

bool BoardEmulator::consume_fault(int node) noexcept {
  if (faults.reply == ReplyFault::kNone || faults.replies == 0) return false;
  if (faults.node >= 0 && faults.node != node) return false;
  if (faults.replies > 0) --faults.replies;
  return true;
}

// The hub's own answers have no CRCs, relayed ones do.
Answer BoardEmulator::send(Reply& reply, int place, ByteSpan out) noexcept {
  const std::size_t size = encode(reply, place == hub() ? Crc::kZero : Crc::kReal, out);
  if (size == 0 || !consume_fault(reply.node)) return {size, 0.0, false};
  return corrupt_reply(size, out);
}

Answer BoardEmulator::corrupt_reply(std::size_t size, ByteSpan out) noexcept {
  const auto change = [&](std::size_t byte, std::uint8_t bits) { out.data[byte] ^= bits; };
  switch (faults.reply) {
    case ReplyFault::kDrop:
      return {};
    case ReplyFault::kDelay:
      return {size, faults.delay, false};
    case ReplyFault::kTruncate:
      return {size - 4, 0.0, false};
    case ReplyFault::kExtend:
      return {size + 4 <= out.size ? size + 4 : size, 0.0, false};
    case ReplyFault::kLabel:
      change(2, 0x08);
      break;
    case ReplyFault::kTcode:
      change(3, 0x10);
      break;
    case ReplyFault::kNode:
      change(5, 0x07);
      break;
    case ReplyFault::kLength:
      change(13, 0x04);
      break;
    case ReplyFault::kBus:
      change(4, 0x80);
      break;
    case ReplyFault::kCrc:
      change(19, 0x55);
      break;
    case ReplyFault::kOld: {
      // Repeats only blocks of the hub itself, whose header has no CRC that the new label would invalidate, and
      // only of equal size.
      constexpr std::size_t kWithLabel = 4, kHeaderCrc = 16;
      const bool blocks = size > kHeaderCrc + 4 && (old_size_ == 0 || old_size_ == size) && (out.data[3] >> 4) == 7;
      if (!blocks || load_quadlet(out.data + kHeaderCrc) != 0) break;
      if (old_size_ == 0) std::copy_n(out.data, size, old_.data());
      old_size_ = size;
      std::copy(old_.data() + kWithLabel, old_.data() + size, out.data + kWithLabel);
      break;
    }
    case ReplyFault::kForeign:
      return {size, 0.0, true};
    case ReplyFault::kNone:
      break;
  }
  return {size, 0.0, false};
}

}  // namespace veridyn::dvrk
