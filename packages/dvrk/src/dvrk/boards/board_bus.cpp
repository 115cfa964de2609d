#include "dvrk/boards/board_bus.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <set>
#include <utility>

#include "dvrk/protocol/hub_block.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

constexpr double kQueryLatency = 10e-6;  // [s] from the query to the first block in the hub: specification 8.3, #3
constexpr double kQueryPerBoard = 10e-6;
constexpr double kShortestWait = 0.001;  // [s] timeout of a reply if the cycle is late already
constexpr double kLateCycles = 2.5;      // cycles between time stamps that indicate a missed one
constexpr int kRegisterEvery = 4;        // cycles between two reads of a command of Rev 7
constexpr double kJump = 0.005;          // [s] difference of timestamp and clock, from which the board is checked

}  // namespace

BoardBus::BoardBus(DatagramLink& link, const BusOptions& options)
    : link_(link), options_(options), exchange_(link, log_) {
  require(!options.boards.empty() && options.boards.size() <= kMaxBoards, "boards: found ",
          options.boards.size(), " in use, expected 1 to 16.");
  require(options.reply_timeout > 0.0 && options.rescan_timeout > 0.0,
          "boards: timeouts must be positive.");
  require(options.mtu >= 576, "boards: found an MTU of ", options.mtu, ", expected 576 or more.");
  if (listens() && !options.announce) listen();
  const std::set<int> ids(options.boards.begin(), options.boards.end());
  require(ids.size() == options.boards.size(), "boards: an id is given twice.");
  for (const int id : ids) {
    require(id >= 0 && id < kMaxBoards, "boards: found id ", id, ", expected 0 to 15.");
    Board b;
    b.info.id = id;
    b.command.board = static_cast<std::uint8_t>(id);
    b.zero.fill(kZeroCurrent);
    boards_.push_back(b);
  }
}

void BoardBus::listen() noexcept {
  exchange_.listen_only(options_.protocol == CycleProtocol::kBroadcast ? Exchange::Queries::kAllowed
                                                                       : Exchange::Queries::kNone);
}

void BoardBus::note(Condition condition, std::optional<int> board, std::optional<int> channel,
                    std::uint32_t value) noexcept {
  log_.note(condition, link_.now(), board, channel, value);
}

Route BoardBus::route(const Board& b) const {
  assert(b.info.node);
  return route_to(*b.info.node);
}

// Without FireWire a node's number is its board's id, and each board has its own address: specification 2.3.
Route BoardBus::route_to(int node) const {
  return {static_cast<std::uint8_t>(node), ethernet_only_, Destination::kBoard, ethernet_only_ ? std::make_optional(node) : std::nullopt};
}

Route BoardBus::broadcast_route() const {
  return {kBroadcastNode, ethernet_only_,
          ethernet_only_ ? Destination::kMulticast : Destination::kBoard};
}

// True if all boards have firmware with the same packet layout.
bool BoardBus::one_group() const noexcept {
  const int group = firmware_group(boards_.front().info.firmware);
  return std::all_of(boards_.begin(), boards_.end(),
                     [&](const Board& b) { return firmware_group(b.info.firmware) == group; });
}

void BoardBus::set_zero(int b, int channel, std::uint16_t bits) noexcept {
  boards_[b].zero[channel] = bits;
}

// Marks the board's feedback as invalid and counts a lost read.
void BoardBus::mark_lost_read(Board& b, Condition why) noexcept {
  b.valid = false;
  b.loss = why;
  ++b.lost_reads;
}

void BoardBus::log_lost_read(Board& b, Condition why, std::uint32_t word) noexcept {
  note(why, b.info.id, {}, word);
  mark_lost_read(b, why);
}

bool BoardBus::read() noexcept {
  ++cycles_;
  exchange_.reset_queue_delay();
  if (state_ == BusState::kRunning && exchange_.generation_changed())
    begin_scan(Condition::kGenerationChanged);
  if (state_ != BusState::kRunning) {
    for (Board& b : boards_) mark_lost_read(b, Condition::kGenerationChanged);
    if (state_ == BusState::kScanning) scan_step();
    return false;
  }
  exchange_.repeat_after(options_.repeat_after);
  if (options_.access == Access::kListenByRegister) {
    read_by_register();
  } else if (protocol_ == CycleProtocol::kBroadcast && !silent_) {
    read_broadcast();
  } else {
    read_sequential();
  }
  for (Board& b : boards_)
    if (b.valid && b.hidden) read_back_command(b, *b.hidden);
  if (options_.access == Access::kDrive && boards_.front().info.firmware < 8 &&
      cycles_ % kRegisterEvery == 0)
    check_written_commands();
  poll_registers();
  return std::all_of(boards_.begin(), boards_.end(), [](const Board& b) { return b.valid; });
}

// Requests the block of every board, one after the other.
void BoardBus::read_sequential() noexcept {
  const double start = link_.now();
  link_lost_ = false;
  for (Board& b : boards_) {
    const double asked = link_.now();
    const double left = options_.reply_timeout - (asked - start);
    QuadletView block;
    const ReadResult result =
        exchange_.read_block(route(b), address::kRealTime, read_quadlets(b.info.firmware),
                             std::max(left, kShortestWait), block);
    link_lost_ = link_lost_ || result == ReadResult::kNotSent;
    if (result == ReadResult::kOk) {
      accept_block(b, block, asked);
    } else {
      mark_lost_read(b, condition_of(result));
    }
    if (result == ReadResult::kDropped) {  // nodes may have changed: none is addressed now (specification 17 #3)
      for (Board* other = &b + 1; other < boards_.data() + boards_.size(); ++other)
        mark_lost_read(*other, Condition::kDropped);
      if (state_ == BusState::kRunning) begin_scan(Condition::kGenerationChanged);
      return;
    }
  }
}

// Queries all boards by broadcast, then reads their blocks from the hub: specification 8.3.
void BoardBus::read_broadcast() noexcept {
  std::uint16_t mask = 0;
  std::size_t quadlets = 1;
  for (const Board& b : boards_) {
    mask = static_cast<std::uint16_t>(mask | (1U << b.info.id));
    quadlets += hub_quadlets(b.info.firmware);
  }
  sequence_ = next_sequence(sequence_);
  const double asked = link_.now();
  link_lost_ = !exchange_.write(broadcast_route(), address::kHubQuery, query_word(sequence_, mask));
  link_.wait(kQueryLatency + kQueryPerBoard * static_cast<double>(boards_.size() - 1));
  QuadletView data;
  const ReadResult result =
      exchange_.read_block({static_cast<std::uint8_t>(hub_node_), false, Destination::kBoard},
                           address::kHub, quadlets, options_.reply_timeout, data);
  if (result != ReadResult::kOk) {
    for (Board& b : boards_) mark_lost_read(b, condition_of(result));
    link_lost_ = link_lost_ || result == ReadResult::kNotSent;
    if (result == ReadResult::kDropped) begin_scan(Condition::kGenerationChanged);
    return;
  }
  std::size_t at = 0;
  for (Board& b : boards_) {
    const int firmware = b.info.firmware;
    const std::size_t size = read_quadlets(firmware);
    const std::uint32_t word = data[at];
    const HubHeader header = decode_hub_header(word, firmware);
    const QuadletView block = data.part(at + 1, size);
    at += 1 + size;
    if (word == 0 || block[1] == 0) {
      log_lost_read(b, Condition::kMissingBoard, word);
    } else if (firmware >= 8 && header.quadlets != hub_quadlets(firmware)) {
      log_lost_read(b, Condition::kWrongBlockSize, word);
    } else if (!answers(header, sequence_, firmware)) {
      log_lost_read(b, Condition::kStaleSequence, word);
    } else {
      accept_block(b, block, asked);
    }
  }
}

// Interval [s] from the first request to the last reply of this cycle.
BoardBus::Interval BoardBus::measured() const noexcept {
  Interval all{boards_.front().asked_at, 0.0};
  for (const Board& b : boards_) {
    all.from = std::min(all.from, b.asked_at);
    all.to = std::max(all.to, b.read_at.value_or(b.asked_at));
  }
  return all;
}

// Stores a board's block after checks of its origin, or logs a lost read; `asked` [s] is the time of the
// request.
void BoardBus::accept_block(Board& b, QuadletView block, double asked) noexcept {
  const Status status{block[1]};
  if (status.board() != b.info.id) {
    log_lost_read(b, Condition::kWrongBoard, status.word);
    if (state_ == BusState::kRunning) begin_scan(Condition::kWrongBoard);
    return;
  }
  if (status.channels() != kChannels) {
    log_lost_read(b, Condition::kWrongHardware, status.word);
    return;
  }
  // A board that no longer requests relay or power may have restarted (specification 17 #25).
  constexpr std::uint32_t kRequests = (1U << 18) | (1U << 16);
  if (((b.feedback.status.word & ~status.word) & kRequests) != 0) b.suspect = true;
  b.feedback = decode_feedback(block, b.info.firmware);
  b.valid = true;
  b.asked_at = asked;
  b.lost_reads = 0;
  check_timestamp(b);
  check_commands(b);
}

// Detects missed cycles by the timestamp (specification 17 #26). If it differs from our clock, the board may
// have restarted (#25) and is checked.
void BoardBus::check_timestamp(Board& b) noexcept {
  const double now = link_.now();
  const std::optional<double> before = std::exchange(b.read_at, now);
  if (!before) return;
  const double passed = now - *before;
  const double told = b.feedback.seconds();
  const bool late = options_.cycle_time > 0.0 && told > kLateCycles * options_.cycle_time;
  if (b.feedback.timestamp == 0 || late)
    note(Condition::kTimestamp, b.info.id, {}, b.feedback.timestamp);
  if (std::abs(told - passed) > kJump) b.suspect = true;
}

// Detects lost writes: the board shows the last command that it executed (specification 17 #27).
void BoardBus::check_commands(Board& b) noexcept {
  if (b.info.firmware < 8) return;  // check_written_commands() reads its registers
  for (size_t c = 0; c < kChannels; ++c) {
    const std::uint16_t shown = b.feedback.channel[c].motor.command();
    // The last write may still be in transmission, since a network may let a read overtake it.
    if (!b.has_sent[c] || shown == b.sent[c] || shown == b.before[c]) continue;
    b.hidden = c;
    ++b.lost_writes;
    return;
  }
  b.hidden.reset();
  b.lost_writes = 0;
}

}  // namespace veridyn::dvrk
