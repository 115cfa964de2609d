#include <algorithm>
#include <array>
#include <iomanip>

#include "dvrk/boards/board_bus.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/math/text_stream.hpp"

// Bus scan at the start of a session (specification 5) and whenever nodes may have changed (specification 6).

namespace veridyn::dvrk {
namespace {

constexpr double kAfterIpAddress = 0.200;  // [s] wait after the IP address was sent: specification 5, #1
constexpr double kAfterPhyRequest = 0.010;
constexpr int kScannedNodes = 16;
constexpr double kRepeatShare = 0.4;  // share of the timeout after which a request is repeated outside of a cycle

// Gap counts that are sufficient for 1, 2, 3, ... cable hops (IEEE 1394a-2000, annex E.1). As in the dVRK
// library, the index is the number of nodes, one more than the hops of a chain: a reserve for a
// node that does not answer register reads, such as a computer on the bus.
constexpr std::array<std::uint8_t, 16> kGapCount = {5,  7,  8,  10, 13, 16, 18, 21,
                                                    24, 26, 29, 32, 35, 37, 40, 43};
constexpr std::uint32_t kGapCountNever = 63;  // gap count of power-up
constexpr std::uint32_t kReadPhy1 = 1;
constexpr std::uint32_t kWritePhy1 = 0x1100;

Route hub_route() {
  return {kBroadcastNode, true, Destination::kEveryone};
}

std::string hex(std::uint32_t value) {
  TextStream out;
  out << "0x" << std::hex << std::setw(8) << std::setfill('0') << value;
  return out.str();
}

}  // namespace

void BoardBus::find_hub() {
  Route hub = hub_route();
  std::uint32_t hardware = 0, status = 0, firmware = 0, ethernet = 0;
  const bool writes = !listens() || options_.announce;
  if (writes) {
    exchange_.write(hub, address::kIpAddress, link_.address_word());
    link_.wait(kAfterIpAddress);
  }
  const ReadResult answer =
      exchange_.read(hub, address::kHardware, options_.reply_timeout, hardware);
  require(answer != ReadResult::kNotSent, "boards: the link cannot send.");
  require(answer == ReadResult::kOk, "boards: no board answers",
          writes ? "." : ". Boards that were just switched on need --announce once.");
  if (writes) {
    exchange_.write(hub, address::kPhyRequest, 0);
    link_.wait(kAfterPhyRequest);
    if (listens()) listen();
  }
  const double timeout = options_.reply_timeout;
  require(exchange_.read(hub, address::kStatus, timeout, status) == ReadResult::kOk &&
              exchange_.read(hub, address::kFirmware, timeout, firmware) == ReadResult::kOk,
          "boards: the hub does not tell its status and firmware.");
  link_.set_hub(static_cast<int>(firmware), Status{status}.board());
  if (firmware >= 9) hub.to = Destination::kMulticast;  // Rev 9 boards share a multicast group: specification 2.3
  exchange_.expect_silence(true);                       // probe() reports missing replies
  exchange_.read(hub, address::kEthernet, timeout, ethernet);
  exchange_.expect_silence(false);
  ethernet_only_ = !options_.firewire && firmware >= 9 && is_fpga_v3(ethernet);
}

// Reads the identity of a node (specification 5 #7). A node that does not answer counts as missing.
void BoardBus::probe(int node, double timeout) noexcept {
  const Route route = route_to(node);
  BoardInfo& info = scan_.found[node];
  info = BoardInfo();
  std::uint32_t firmware = 0, git = 0;
  exchange_.expect_silence(true);
  const ReadResult there = exchange_.read(route, address::kHardware, timeout, info.hardware);
  exchange_.expect_silence(false);
  if (there != ReadResult::kOk) return;
  if (exchange_.read(route, address::kFirmware, timeout, firmware) != ReadResult::kOk) return;
  if (firmware >= 5 &&
      exchange_.read(route, address::kEthernet, timeout, info.ethernet) != ReadResult::kOk)
    return;
  if (exchange_.read(route, address::kStatus, timeout, info.status) != ReadResult::kOk) return;
  exchange_.read(route, address::kGitDescription, timeout, git);  // may fail
  info.firmware = static_cast<int>(firmware);
  info.id = Status{info.status}.board();
  info.node = node;
}

// Sets the gap count of all nodes (specification 5 #8): it must be the same on all, and is too large after power-up.
void BoardBus::set_gap_count() noexcept {
  const Route all{kBroadcastNode, false, Destination::kBoard};
  exchange_.write(all, address::kPhyRequest, kReadPhy1);
  link_.wait(kAfterPhyRequest);
  std::size_t nodes = 0;
  std::uint32_t low = kGapCountNever, high = 0;
  for (const BoardInfo& found : scan_.found) {
    if (!found.node) continue;
    ++nodes;
    std::uint32_t result = 0;
    const Route one{static_cast<std::uint8_t>(*found.node), false, Destination::kBoard};
    if (exchange_.read(one, address::kPhyResult, options_.reply_timeout, result) != ReadResult::kOk)
      return;
    low = std::min(low, result & 0x3F);
    high = std::max(high, result & 0x3F);
  }
  if (nodes == 0 || (low == high && low > 0 && low < kGapCountNever)) return;
  const std::size_t place = std::min(nodes, kGapCount.size()) - 1;
  exchange_.write(all, address::kPhyRequest, kWritePhy1 + kGapCount[place]);
}

bool BoardBus::all_found() const noexcept {
  return std::all_of(boards_.begin(), boards_.end(), [this](const Board& b) {
    return std::any_of(scan_.found.begin(), scan_.found.end(), [&](const BoardInfo& found) {
      return found.node && found.id == b.info.id;
    });
  });
}

// Gives the boards in use their nodes.
BoardBus::Objection BoardBus::assign() noexcept {
  unsigned seen = 0;
  for (Board& b : boards_) b.info.node.reset();
  for (const BoardInfo& found : scan_.found) {
    if (!found.node) continue;
    if (((seen >> found.id) & 1U) != 0) {
      note(Condition::kDuplicateBoard, found.id, {}, static_cast<std::uint32_t>(*found.node));
      return {Condition::kDuplicateBoard, found.id};
    }
    seen |= 1U << found.id;
    for (Board& b : boards_) {
      if (b.info.id == found.id) b.info = found;
    }
  }
  for (int k = 0; k < boards(); ++k) {
    const BoardInfo& there = info(k);
    Objection objection{Condition::kNoReply, k};
    if (!there.node) {
      objection.condition = Condition::kMissingBoard;
    } else if (there.hardware != kHardwareQla1 || Status{there.status}.channels() != kChannels) {
      objection.condition = Condition::kWrongHardware;
    } else if (!firmware_supported(there.firmware)) {
      objection.condition = Condition::kWrongFirmware;
    } else {
      continue;
    }
    note(objection.condition, there.id, {}, there.hardware);
    return objection;
  }
  return {};
}

std::string BoardBus::words_of(const Objection& objection) const {
  if (objection.condition == Condition::kDuplicateBoard)
    return text("found board id ", *objection.board, " on two nodes; ids must be unique.");
  const BoardInfo& there = info(*objection.board);
  if (objection.condition == Condition::kWrongHardware)
    return text("board ", there.id, ": found hardware ", hex(there.hardware), " with ",
                Status{there.status}.channels(), " channels, expected a QLA (", hex(kHardwareQla1),
                ") with 4.");
  if (objection.condition == Condition::kWrongFirmware)
    return text("board ", there.id, ": found firmware ", there.firmware, ", expected 6 to 9.");
  std::string others;
  for (const BoardInfo& found : scan_.found) {
    if (found.node) others += text(others.empty() ? " " : ", ", found.id);
  }
  return text("board ", there.id, " does not answer; found", others.empty() ? " none" : others,
              ethernet_only_ ? " on an Ethernet without FireWire (--firewire: there is one)." : ".");
}

// Chooses the protocol of the cycle by firmware and MTU: specification 5, end, and section 17 #11 and #16.
void BoardBus::choose_protocol() {
  const bool same = one_group();
  protocol_ = options_.protocol;
  if (listens() && protocol_ != CycleProtocol::kBroadcast) protocol_ = CycleProtocol::kSequential;
  if (protocol_ == CycleProtocol::kAutomatic)
    protocol_ = same ? CycleProtocol::kBroadcastWrite : CycleProtocol::kSequential;
  if (!same && protocol_ != CycleProtocol::kSequential) {
    note(Condition::kWrongFirmware);
    throw InvalidInput(
        "boards: found firmware of several groups (6, 7, 8 to 9), expected one for a broadcast "
        "protocol; the sequential protocol takes any mix.");
  }
  if (protocol_ != CycleProtocol::kBroadcast) return;
  require(!ethernet_only_, "boards: found the broadcast protocol for boards that Ethernet alone joins, "
          "expected sequential or broadcast-write.");
  require(boards_.front().info.firmware >= 7, "boards: the broadcast protocol needs firmware 7.");
  std::size_t bytes = 4;
  for (const Board& b : boards_) bytes += 4 * hub_quadlets(b.info.firmware);
  if (bytes <= largest_read(options_.mtu)) return;
  note(Condition::kTooLarge, {}, {}, static_cast<std::uint32_t>(bytes));
  throw InvalidInput(text("boards: a broadcast read of ", boards_.size(), " boards has ", bytes,
                          " bytes, but an MTU of ", options_.mtu, " takes ",
                          largest_read(options_.mtu), "; use the sequential protocol."));
}

void BoardBus::start() {
  state_ = BusState::kClosed;
  link_lost_ = false;
  exchange_.repeat_after(options_.repeat_after > 0.0 ? kRepeatShare * options_.reply_timeout : 0.0);
  find_hub();
  exchange_.adopt_generation();
  for (int node = 0; node < kScannedNodes; ++node) probe(node, options_.reply_timeout);
  if (!all_found()) {  // a datagram may have been lost
    for (int node = 0; node < kScannedNodes; ++node) {
      if (!scan_.found[node].node) probe(node, options_.reply_timeout);
    }
  }
  require(!exchange_.generation_changed(), "boards: the bus was reset during the scan.");
  const Objection wrong = assign();
  require(!wrong.board, "boards: ", wrong.board ? words_of(wrong) : "");
  choose_protocol();
  if (!listens() && !ethernet_only_) set_gap_count();
  hub_node_ = 0;
  std::uint32_t status = 0;  // the node that answers a broadcast is the hub
  if (exchange_.read(hub_route(), address::kStatus, options_.reply_timeout, status) ==
      ReadResult::kOk) {
    for (const BoardInfo& found : scan_.found) {
      if (found.node && found.id == Status{status}.board()) hub_node_ = *found.node;
    }
  }
  for (Board& b : boards_) {
    b.valid = b.rebooted = b.suspect = false;
    b.lost_reads = b.lost_writes = 0;
    b.read_at.reset();
    b.has_sent.fill(false);
  }
  state_ = BusState::kRunning;
}

void BoardBus::begin_scan(Condition why) noexcept {
  if (why == Condition::kDropped && exchange_.generation_changed()) why = Condition::kGenerationChanged;
  if (state_ != BusState::kScanning) unrest_ = why;
  state_ = BusState::kScanning;
  scan_ = Scan();
}

// Scans one node per call, so that a control loop can send "off" in between (specification 20: a complete
// scan takes longer than the watchdog allows).
void BoardBus::scan_step() noexcept {
  const double timeout = options_.rescan_timeout;
  if (scan_.node == 0) {  // the hub answers whatever the generation is
    std::uint32_t status = 0;
    if (exchange_.read(hub_route(), address::kStatus, timeout, status) != ReadResult::kOk) return;
    if (exchange_.resetting()) return;
    exchange_.adopt_generation();
  }
  probe(scan_.node, timeout);
  if (exchange_.generation_changed() || exchange_.resetting()) return begin_scan(unrest_);
  if (++scan_.node < kScannedNodes) return;
  std::uint32_t status = 0;
  if (exchange_.read(hub_route(), address::kStatus, timeout, status) != ReadResult::kOk)
    return begin_scan(unrest_);
  std::array<int, kMaxBoards> firmware{};
  for (size_t k = 0; k < boards_.size(); ++k) firmware[k] = boards_[k].info.firmware;
  const Objection wrong = assign();
  if (wrong.board) {
    if (wrong.condition == Condition::kMissingBoard) return begin_scan(unrest_);  // it may come back
    state_ = BusState::kRefused;
    return;
  }
  for (const BoardInfo& found : scan_.found) {
    if (found.node && found.id == Status{status}.board()) hub_node_ = *found.node;
  }
  for (size_t k = 0; k < boards_.size(); ++k) {
    Board& b = boards_[k];
    if (b.info.firmware != firmware[k]) {
      note(Condition::kWrongFirmware, b.info.id);
      state_ = BusState::kRefused;
      return;
    }
    b.suspect = true;  // it may have been off in the meantime
    b.read_at.reset();
    b.has_sent.fill(false);
  }
  state_ = BusState::kRunning;
}

}  // namespace veridyn::dvrk
