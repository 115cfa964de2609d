#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "veridyn/dvrk/protocol/command.hpp"
#include "veridyn/dvrk/protocol/exchange.hpp"
#include "veridyn/dvrk/protocol/fault_log.hpp"
#include "veridyn/dvrk/protocol/feedback.hpp"

namespace veridyn::dvrk {

/// Protocol of a cycle, by section of the firmware I/O specification (8.1 to 8.3).
enum class CycleProtocol {
  kAutomatic,       ///< kBroadcastWrite where the firmware allows it, else kSequential
  kSequential,      ///< 8.1: one read and one write for each board
  kBroadcastWrite,  ///< 8.2: one read for each board, one write for all
  kBroadcast        ///< 8.3: query, one read of all boards, one write
};

/// Access of a client to the boards.
enum class Access {
  kDrive,  ///< reads and writes
  /// Only reads: no packet is sent that changes a board, so that another client may drive it. Reads of
  /// real-time blocks, however, restart the boards' timestamps, which affects that client.
  kListen,
  kListenByRegister  ///< reads single registers only, which changes nothing at all but is slow
};

struct BusOptions {
  std::vector<int> boards;  ///< ids of the boards in use
  Access access = Access::kDrive;
  /// While listening: still sends the two packets of a session's start, which give boards after
  /// power-up their address (specification 5, #1 and #3).
  bool announce = false;
  CycleProtocol protocol = CycleProtocol::kAutomatic;
  double reply_timeout = 0.020;      ///< [s]; also for all replies of a cycle
  /// [s] after which a read without a reply is repeated within a cycle (Exchange); 0: never. A reply takes
  /// 0.15 ms, so that the rest of the cycle is sufficient for the wait.
  double repeat_after = 0.001;
  double rescan_timeout = 0.005;     ///< [s] limit per node while the cycle runs on
  double cycle_time = 1.0 / 1500.0;  ///< [s] nominal; 0: timestamps are not judged
  /// FireWire connects the boards, although the hub is an FPGA V3 with firmware 9, which otherwise means a
  /// bus of Ethernet alone.
  bool firewire = false;
  std::size_t mtu = 1500;            ///< [bytes] largest packet on the route to the boards
  int housekeeping = 200;            ///< cycles between two reads of a slow register; 0: none
};

struct BoardInfo {
  int id = -1;
  std::optional<int> node;  ///< nullopt: not found on the bus
  int firmware = 0;
  std::uint32_t hardware = 0;
  std::uint32_t status = 0;
  std::uint32_t ethernet = 0;
};

enum class BusState {
  kClosed,  ///< start() was not called
  kRunning,
  kScanning,  ///< nodes have changed; read() searches for the boards again, one node per call
  kRefused    ///< the boards that were found cannot be used: call start() again
};

/// The client's side of the boards: bus scan, real-time cycle, registers. Detects conditions 1 to
/// 16 and 25 to 30 of section 17; BoardSession handles those that boards report (17 to 24). A parameter `b` is
/// the index of a board in ascending ids, `channel` counts from 0. After
/// start() nothing allocates or throws.
class BoardBus {
 public:
  /// @throws InvalidInput  no boards, too many, an id that occurs twice or is above 15.
  BoardBus(DatagramLink& link, const BusOptions& options);

  /// Starts a session as in section 5, which takes about half a second.
  /// While listening nothing is written, and the protocol is the sequential one, unless a
  /// broadcast read is requested: that needs a query, which is a write that changes no output.
  ///
  /// @throws InvalidInput  no hub; a board in use is missing, occurs twice, or is not supported; a broadcast
  /// protocol with mixed firmware, or one that does not fit the MTU.
  void start();

  BusState state() const { return state_; }
  CycleProtocol protocol() const { return protocol_; }
  bool ethernet_only() const { return ethernet_only_; }
  int boards() const { return static_cast<int>(boards_.size()); }
  const BoardInfo& info(int b) const { return boards_[b].info; }
  const FaultLog& faults() const { return log_; }
  FaultLog& faults() { return log_; }

  /// Reads all boards. @returns true if all of them are valid.
  bool read() noexcept;
  /// While silent, reads send no query, because a query is a write that resets watchdogs (specification 14.1).
  void set_silent(bool silent) noexcept { silent_ = silent; }
  bool valid(int b) const { return boards_[b].valid; }
  const BoardFeedback& feedback(int b) const { return boards_[b].feedback; }
  /// Cycles in a row without a valid read.
  int lost_reads(int b) const { return boards_[b].lost_reads; }
  /// Reason for the last lost read.
  Condition loss_reason(int b) const { return boards_[b].loss; }
  /// Cycles in a row in which a command was not found in the motor status; on Rev 7 in the registers of its
  /// channels, of which one is read every few cycles.
  int lost_writes(int b) const { return boards_[b].lost_writes; }
  /// Why the block of board b does not show the last command: kNotEffective, or kOldReplies where the channel's
  /// register holds the command.
  Condition unconfirmed_reason(int b) const { return boards_[b].unshown; }
  /// Checks in the next cycles, one board in each, whether a board has restarted, by its registers.
  void check_all_for_restart() noexcept {
    for (Board& b : boards_) b.suspect = true;
  }
  /// The board has restarted: watchdog and preloads have their power-up values.
  bool rebooted(int b) const { return boards_[b].rebooted; }
  bool link_lost() const { return link_lost_; }
  /// Interval in which the present feedback was measured: between its first request and its last reply, which
  /// may have come late [s of the link's clock].
  struct Interval {
    double from = 0.0, to = 0.0;
  };
  Interval measured() const noexcept;
  /// Reason for the present bus scan.
  Condition scan_reason() const { return unrest_; }

  /// Command of the next write(), which resets it to "no change".
  BoardCommand& command(int b) { return boards_[b].command; }
  /// Sends all commands; keeps the watchdogs alive even without commands. While nodes are unknown,
  /// sends switch_off(Off::kAmps) instead.
  void write() noexcept;

  /// Sets zero current and switches amplifiers off, optionally power too, for the boards in use: by
  /// broadcast, which a change of generation cannot lose (specification 6).
  enum class Off { kAmps, kPower };
  void switch_off(Off what) noexcept;
  /// The same for one board through its control register, for boards that ignore blocks. @returns false: not sent.
  bool switch_off_by_register(int b, Off what) noexcept;
  /// DAC bits of zero current, by calibration.
  void set_zero(int b, int channel, std::uint16_t bits) noexcept;

  /// Registers of one board; false, and nothing sent, while nodes are unknown.
  bool read_register(int b, std::uint16_t address, std::uint32_t& value) noexcept;
  bool write_register(int b, std::uint16_t address, std::uint32_t value) noexcept;
  /// Writes and reads back, with two repeats. @returns true if the register has the value.
  bool write_checked(int b, std::uint16_t address, std::uint32_t value) noexcept;
  /// Serial number "1234-56" of a QLA, from its memory: specification 7.6. Empty: none, or it cannot be read.
  std::string qla_serial(int b);
  /// Sets and verifies all watchdogs; clears the record of rebooted boards. @returns true if all were verified.
  bool set_watchdog(double seconds) noexcept;

  const ReplyLoss& reply_loss() const { return exchange_.loss(); }
  /// [s] of the last read() in which replies had arrived, but this program did not run.
  double queue_delay() const { return exchange_.queue_delay(); }

 private:
  struct Board {
    BoardInfo info;
    BoardFeedback feedback;
    BoardCommand command;
    std::array<std::uint16_t, kChannels> zero{};
    std::array<std::uint16_t, kChannels> sent{};    ///< last value of each channel
    std::array<std::uint16_t, kChannels> before{};  ///< the value before it
    std::array<bool, kChannels> has_sent{};
    std::optional<double> read_at;
    double asked_at = 0.0;
    bool valid = false;
    bool rebooted = false;
    bool suspect = false;  ///< its registers are to be checked soon
    int lost_reads = 0;
    Condition loss = Condition::kNoReply;
    int lost_writes = 0;
    std::optional<std::size_t> hidden;  ///< channel whose last command is not in the block
    Condition unshown = Condition::kNotEffective;
  };

  /// Result of a bus scan.
  struct Scan {
    std::array<BoardInfo, kMaxBoards> found{};  ///< identity of every node
    int node = 0;
  };

  /// Reason for refusing the boards found.
  struct Objection {
    Condition condition = Condition::kNoReply;
    std::optional<int> board = {};  ///< index in boards_, or the id that occurs twice; nullopt: no objection
  };

  Route route(const Board& b) const;  ///< only for a board with a known node
  Route route_to(int node) const;
  Route broadcast_route() const;
  /// FaultLog::note() at the present time, with the board's id.
  void note(Condition condition, std::optional<int> board = {}, std::optional<int> channel = {},
            std::uint32_t value = 0) noexcept;

  bool listens() const { return options_.access != Access::kDrive; }
  void listen() noexcept;  ///< from now on writes are suppressed, see Exchange::listen_only()
  /// Announces this client unless it listens, and identifies the hub. @throws InvalidInput  no hub answers.
  void find_hub();
  void set_gap_count() noexcept;
  void probe(int node, double timeout) noexcept;  ///< stores it in scan_; timeout [s] of each read
  bool all_found() const noexcept;  ///< true if the scan found every board in use
  Objection assign() noexcept;
  std::string words_of(const Objection& objection) const;  ///< message for the user
  void choose_protocol();
  void begin_scan(Condition why) noexcept;  ///< state kScanning, from node 0 on
  void scan_step() noexcept;

  void read_sequential() noexcept;
  void read_by_register() noexcept;  ///< kListenByRegister: reads every board word by word
  bool read_words(Board& b, QuadletSpan words) noexcept;  ///< false: the read is marked as lost
  void read_broadcast() noexcept;
  void accept_block(Board& b, QuadletView block, double asked) noexcept;
  void check_timestamp(Board& b) noexcept;
  void check_commands(Board& b) noexcept;
  void mark_lost_read(Board& b, Condition why) noexcept;
  void log_lost_read(Board& b, Condition why, std::uint32_t word) noexcept;  ///< also marks it as lost
  void poll_registers() noexcept;  ///< checks a suspect board, or every BusOptions::housekeeping cycles one
  void check_registers(Board& b) noexcept;
  void check_written_commands() noexcept;
  void read_back_command(Board& b, std::size_t channel) noexcept;

  bool nodes_known() const noexcept;  ///< registers of single boards may be addressed
  void write_blocks() noexcept;  ///< sends all commands by the protocol of the cycle
  void store_written(Board& b) noexcept;  ///< keeps the values for check_commands(), resets the command
  bool one_group() const noexcept;

  DatagramLink& link_;
  BusOptions options_;
  FaultLog log_;
  Exchange exchange_;
  std::vector<Board> boards_;  ///< ascending ids
  Scan scan_;
  BusState state_ = BusState::kClosed;
  CycleProtocol protocol_ = CycleProtocol::kSequential;
  int hub_node_ = 0;
  bool ethernet_only_ = false;  ///< boards on one Ethernet, without FireWire between them
  Condition unrest_ = Condition::kGenerationChanged;
  std::size_t asked_channel_ = 0;  ///< next channel of check_written_commands(), counted over all boards
  std::uint16_t sequence_ = 0;
  std::uint32_t watchdog_counts_ = 0;
  bool link_lost_ = false;
  bool silent_ = false;
  long cycles_ = 0;
  std::array<std::uint8_t, kMaxDatagram> block_{};
};

}  // namespace veridyn::dvrk
