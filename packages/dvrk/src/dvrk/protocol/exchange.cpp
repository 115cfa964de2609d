#include "dvrk/protocol/exchange.hpp"

#include <algorithm>

namespace veridyn::dvrk {
namespace {

constexpr std::uint16_t kHubQuery = address::kHubQuery;
constexpr int kMostStale = 64;  // datagrams that one call discards from the queue
// A timer that ends before the next tick of the system's clock (4 ms apart at 250 Hz) is set in
// hardware and costs as much as the rest of a read. So a read waits longer than a tick, unless a
// reply was missed in the last seconds.
constexpr double kLongerThanTick = 0.005;  // [s] first wait for a reply
constexpr double kWary = 10.0;             // [s] after a missed reply, for which waits are shorter

}  // namespace

Condition condition_of(ReadResult result) {
  switch (result) {
    case ReadResult::kNotSent:
      return Condition::kNotSent;
    case ReadResult::kWrongSize:
      return Condition::kWrongSize;
    case ReadResult::kWrongHeader:
      return Condition::kWrongHeader;
    case ReadResult::kWrongCrc:
      return Condition::kWrongCrc;
    case ReadResult::kDropped:
      return Condition::kDropped;
    case ReadResult::kNoReply:
    case ReadResult::kOk:
      break;
  }
  return Condition::kNoReply;
}

Request Exchange::request(const Route& route, Tcode tcode, std::uint16_t address) noexcept {
  label_ = static_cast<std::uint8_t>((label_ + 1) % kLabels);
  Request r;
  r.flags = route.local ? kNoForward : std::uint8_t{0};
  r.generation = generation_;
  r.node = route.node;
  r.label = label_;
  r.tcode = tcode;
  r.address = address;
  return r;
}

bool Exchange::send(const Request& request, const Route& route) noexcept {
  if (route.board) link_.set_board(*route.board);
  sent_ = encode(request, {out_.data(), out_.size()});
  if (sent_ > 0 && link_.send({out_.data(), sent_}, route.to)) return true;
  log_.note(Condition::kNotSent, link_.now());
  return false;
}

// Discards datagrams that arrived before this request, and reports them: specification 17 #7.
void Exchange::drain() noexcept {
  for (int k = 0; k < kMostStale; ++k) {
    const Arrival stale = link_.receive({in_.data(), in_.size()}, 0.0);
    if (!stale.any) return;
    if (stale.known_source && answers_repeated({in_.data(), stale.size})) continue;
    log_.note(stale.known_source ? Condition::kStaleReply : Condition::kForeignSender, link_.now(),
              {}, {}, static_cast<std::uint32_t>(stale.size));
  }
}

// True if a datagram is another reply to a request that was sent twice.
bool Exchange::answers_repeated(ByteView datagram) const noexcept {
  constexpr std::size_t kWithLabel = 8;
  if (!repeated_ || datagram.size <= kWithLabel) return false;
  return static_cast<int>((load_quadlet(datagram.data) >> 10) & 0x3F) == repeated_;
}

// Reads generation, bus reset and packet errors from a trailer: specification 4.3 and section 17 #4, #5, #28.
void Exchange::read_trailer(const Trailer& trailer) noexcept {
  const double now = link_.now();
  const bool errors = packet_errors_ && trailer.packet_errors != packet_errors_;
  packet_errors_ = trailer.packet_errors;
  if (errors || (trailer.flags & (kFlagInternalError | kFlagProtocolError)) != 0)
    log_.note(Condition::kEthernet, now, {}, {}, trailer.flags);
  // The answer to a packet that is not forwarded does not show the state of the FireWire bus; the dVRK library
  // ignores its generation as well. It is used only until another generation is known.
  const bool local = (trailer.flags & kFlagNoForward) != 0;
  const bool changed = learnt_ && !local && trailer.generation != told_;
  if (!learnt_) generation_ = told_ = trailer.generation;
  if (!local) {
    learnt_ = true;
    told_ = trailer.generation;
  }
  if (changed) log_.note(Condition::kGenerationChanged, now, {}, {}, trailer.generation);
  resetting_ = (trailer.flags & kFlagBusReset) != 0;
  if (resetting_) log_.note(Condition::kBusReset, now, {}, {}, trailer.flags);
}

// Compares a reply with its request: specification 4.4, with the sizes of 4.1 and 4.2.
ReadResult Exchange::classify_reply(const Request& request, ByteView datagram, Malformed malformed,
                           const Reply& reply) noexcept {
  const bool block = request.tcode == Tcode::kBlockRead;
  const std::size_t expected = block ? 32 + static_cast<std::size_t>(request.bytes) : 28;
  if (malformed == Malformed::kNone && reply.kind == Reply::Kind::kDropped)
    return ReadResult::kDropped;
  if (datagram.size != expected) return ReadResult::kWrongSize;
  if (malformed != Malformed::kNone) return ReadResult::kWrongHeader;
  const bool right_kind = reply.kind == (block ? Reply::Kind::kBlock : Reply::Kind::kQuadlet);
  const bool right_node = request.node == kBroadcastNode || reply.node == request.node;
  if (!right_kind || !right_node || reply.label != request.label || reply.rcode != 0)
    return ReadResult::kWrongHeader;
  return ReadResult::kOk;
}

// A late reply to an earlier request has an old label: it is discarded, and the wait continues. Any
// other wrong reply ends it.
ReadResult Exchange::await(const Request& request, double until, Reply& reply) noexcept {
  int overdue = 0;  // datagrams read after the timeout, bounded so that a flood ends
  while (true) {
    const double left = until - link_.now();
    if (left <= 0.0 && overdue++ > kMostStale) return ReadResult::kNoReply;
    const Arrival arrival = link_.receive({in_.data(), in_.size()}, left > 0.0 ? left : 0.0);
    const double now = link_.now();
    if (!arrival.any) {
      if (left > 0.0 && now < until) continue;
      return ReadResult::kNoReply;
    }
    if (!arrival.known_source) {
      log_.note(Condition::kForeignSender, now);
      continue;
    }
    lay_ += arrival.lay;
    const ByteView datagram{in_.data(), arrival.size};
    if (repeated_ != request.label && answers_repeated(datagram)) continue;
    const Malformed malformed = decode(datagram, reply);
    if (malformed == Malformed::kNone) read_trailer(reply.trailer);
    const ReadResult result = classify_reply(request, datagram, malformed, reply);
    const auto size = static_cast<std::uint32_t>(arrival.size);
    if (result == ReadResult::kDropped) log_.note(Condition::kDropped, now);
    if (result == ReadResult::kWrongSize) log_.note(Condition::kWrongSize, now, {}, {}, size);
    if (result == ReadResult::kWrongHeader) log_.note(Condition::kWrongHeader, now);
    if (result == ReadResult::kOk && !reply.crc_right) {
      log_.note(Condition::kWrongCrc, now);
      return ReadResult::kWrongCrc;
    }
    const bool late = malformed == Malformed::kNone && reply.kind != Reply::Kind::kDropped &&
                      reply.label != request.label;
    if (!late) return result;
  }
}

// Counts a request; after every ReplyLoss::kRequests of them the lost replies are stored in loss_.
void Exchange::count_request() noexcept {
  if (silence_expected_ || ++requests_ < ReplyLoss::kRequests) return;
  loss_.lost = lost_;
  requests_ = lost_ = 0;
}

ReadResult Exchange::read(const Request& request, const Route& route, double timeout,
                          Reply& reply) noexcept {
  drain();
  if (!send(request, route)) return ReadResult::kNotSent;
  const double until = link_.now() + timeout;
  const bool repeats = repeat_after_ > 0.0 && !silence_expected_;
  const double first = link_.now() < wary_until_ ? repeat_after_ : std::max(repeat_after_, kLongerThanTick);
  double pause = repeat_after_;
  double next = repeats ? link_.now() + first : until;
  count_request();
  for (bool lost = false;; lost = true) {
    const ReadResult result = await(request, std::min(next, until), reply);
    if (result != ReadResult::kNoReply) return result;
    if (!silence_expected_) wary_until_ = link_.now() + kWary;
    if (!silence_expected_ && !lost) {
      ++lost_;
      log_.note(Condition::kLostReplies, link_.now(), {}, {}, request.address);
    }
    if (!(next < until) || link_.now() >= until) break;
    repeated_ = request.label;
    if (!link_.send({out_.data(), sent_}, route.to)) break;
    pause *= 2.0;
    next += pause;
  }
  if (!silence_expected_) log_.note(Condition::kNoReply, link_.now(), {}, {}, request.address);
  return ReadResult::kNoReply;
}

ReadResult Exchange::read(const Route& route, std::uint16_t address, double timeout,
                          std::uint32_t& value) noexcept {
  Reply reply;
  const ReadResult result =
      read(request(route, Tcode::kQuadletRead, address), route, timeout, reply);
  if (result == ReadResult::kOk) value = reply.data;
  return result;
}

ReadResult Exchange::read_block(const Route& route, std::uint16_t address, std::size_t quadlets,
                                double timeout, QuadletView& block) noexcept {
  Request r = request(route, Tcode::kBlockRead, address);
  r.bytes = static_cast<std::uint16_t>(4 * quadlets);
  Reply reply;
  const ReadResult result = read(r, route, timeout, reply);
  if (result == ReadResult::kOk) block = reply.block;
  return result;
}

bool Exchange::write(const Route& route, std::uint16_t address, std::uint32_t value) noexcept {
  if (listens_ && !(queries_ && address == kHubQuery)) return true;
  Request r = request(route, Tcode::kQuadletWrite, address);
  r.data = value;
  return send(r, route);
}

bool Exchange::write_block(const Route& route, std::uint16_t address, QuadletView block) noexcept {
  if (listens_) return true;
  Request r = request(route, Tcode::kBlockWrite, address);
  r.block = block;
  return send(r, route);
}

}  // namespace veridyn::dvrk
