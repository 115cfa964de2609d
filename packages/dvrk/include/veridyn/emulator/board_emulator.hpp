#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "veridyn/emulator/board_load.hpp"
#include "veridyn/dvrk/protocol/bytes.hpp"
#include "veridyn/emulator/emulated_board.hpp"
#include "veridyn/dvrk/protocol/reply.hpp"
#include "veridyn/dvrk/protocol/request.hpp"

namespace veridyn::dvrk {

/// Faults of a reply in transmission.
enum class ReplyFault {
  kNone,
  kDrop,
  kDelay,     ///< the reply is late by EmulatorFaults::delay
  kTruncate,  ///< the last four bytes are missing
  kExtend,    ///< four bytes too many
  kLabel,     ///< Label of an earlier request
  kTcode,     ///< Transaction code of the other kind of read
  kNode,      ///< Node of another board
  kLength,    ///< the length field is wrong, the datagram is not
  kBus,       ///< source bus is not 0x3FF
  kCrc,       ///< wrong and not zero
  kOld,       ///< a hub block that repeats the first one with its label
  kForeign    ///< the reply comes from an unknown address
};

struct EmulatorFaults {
  ReplyFault reply = ReplyFault::kNone;
  int replies = 0;                    ///< Number of replies; -1: all
  int node = -1;                      ///< This node alone; -1: any
  double delay = 0.005;               ///< [s] delay of a kDelay reply
  std::uint8_t flags = 0;             ///< set in every trailer
  std::uint8_t packet_errors = 0;     ///< the count in every trailer
  std::uint8_t generation_ahead = 0;  ///< added to the generation in every trailer
  bool lose_writes = false;           ///< writes never arrive
  double loss = 0.0;                  ///< share of datagrams that are lost, each way
};

/// One reply of the emulator; size 0: none.
struct Answer {
  std::size_t size = 0;
  double delay = 0.0;    ///< [s] time after which it leaves
  bool foreign = false;  ///< true if it must be sent from another address
};

/// Several boards on one FireWire bus behind one Ethernet port, as a client sees them: specification 2 to 11 and
/// 14 (bridge mode). A function of datagrams and times only; BoardServer adds the UDP sockets. handle() does
/// not allocate.
class BoardEmulator {
 public:
  /// Node numbers are the indices in the list; the first board is the hub.
  /// @throws InvalidInput  no boards, more than 16, an id that occurs twice or is above 15, an unknown
  /// firmware.
  explicit BoardEmulator(const std::vector<BoardSetup>& boards, std::uint8_t generation = 1);

  /// Attaches the load of the motors; not owned. The default is a StandingLoad.
  void attach(BoardLoad* load);

  /// Executes a datagram at a time that never decreases.
  Answer handle(ByteView datagram, Ticks now, ByteSpan reply) noexcept;

  Ticks time() const { return now_; }

  /// Moves the load and all boards on to `now`; the first call sets the clock.
  void advance(Ticks now) noexcept;

  int boards() const { return static_cast<int>(boards_.size()); }
  EmulatedBoard& board(int place) { return boards_[place]; }  ///< place: index in the constructor's list
  int node_of(int place) const { return nodes_[place]; }  ///< node of the board with this index
  /// Restarts a board, which also resets the bus.
  void reboot(int place);

  /// FireWire bus reset: the generation is incremented, everything is dropped for `seconds`, and then nodes
  /// have these numbers (empty: the same).
  void bus_reset(double seconds = 0.0, const std::vector<int>& nodes = {});
  std::uint8_t generation() const { return generation_; }

  /// Section 8.5: FPGA V3 with firmware 9, connected by Ethernet alone. Call it before the first datagram.
  void without_firewire() noexcept;

  PowerChain chain;
  EmulatorFaults faults;
  /// Ticks in every trailer: packet received, answer sent.
  std::uint16_t receive_ticks = 400;
  std::uint16_t total_ticks = 900;

  struct Counters {
    long requests = 0;
    long malformed = 0;
    long dropped = 0;
    long wrong_crc = 0;
    long writes = 0;  ///< write requests of any kind, before losses
  };
  const Counters& counters() const { return counters_; }

 private:
  /// A board's block in the hub: the present one and the next one, which arrives at `at`.
  struct HubSlot {
    std::array<std::uint8_t, 4 * 33> now{}, next{};
    Ticks at = 0;
    bool pending = false;
    std::uint16_t sequence = 0;
  };

  BoardLoad& load_or_none() { return load_ != nullptr ? *load_ : standing_; }
  bool resetting() const { return now_ < reset_until_; }
  int place_of(int node) const noexcept;  ///< index of the board at a node; -1: none
  int requesting_reader(const Request& request) const noexcept;  ///< index of the board that executes a request; -1: none
  int hub() const { return 0; }  ///< index of the hub
  Answer execute(const Request& request, ByteSpan reply) noexcept;
  void write(const Request& request) noexcept;  ///< executes it on every board that it reaches
  void write_to(EmulatedBoard& board, const Request& request) noexcept;
  Answer read(const Request& request, int place, ByteSpan reply) noexcept;  ///< reply of the board at this index
  Answer answer_query(const Request& query, ByteSpan reply) noexcept;
  void read_block(const Request& request, int place, QuadletSpan out) noexcept;  ///< of that board, or of the hub's memory
  void start_query(std::uint32_t word) noexcept;
  void update_hub() noexcept;  ///< blocks that are due become the present ones
  void read_hub(QuadletSpan out) noexcept;  ///< blocks of the queried boards in ascending ids, then the timing
  Trailer trailer(std::uint8_t flags) const noexcept;
  Answer send(Reply& reply, int place, ByteSpan out) noexcept;
  bool consume_fault(int node) noexcept;  ///< true if the next reply of this node is to be corrupted; counts it
  Answer corrupt_reply(std::size_t size, ByteSpan out) noexcept;  ///< applies faults.reply to the encoded reply
  bool is_lost() noexcept;  ///< draws whether a datagram is lost

  std::vector<EmulatedBoard> boards_;
  std::vector<int> nodes_;
  std::vector<int> by_id_;  ///< places in ascending order of their ids
  std::vector<MotorDrive> drives_;
  std::vector<ChannelMotion> motions_;
  std::vector<HubSlot> slots_;  ///< one per board
  StandingLoad standing_;
  BoardLoad* load_ = nullptr;
  Ticks now_ = 0;
  bool started_ = false;
  bool ethernet_only_ = false;
  Ticks reset_until_ = 0;
  std::uint8_t gap_count_ = 63;  ///< Gap count of all PHYs, that of power-up
  std::uint8_t echo_ = 0;        ///< trailer flags that repeat those of the request
  Ticks query_at_ = 0;
  std::uint32_t query_ = 0;
  std::uint8_t generation_;
  Counters counters_;
  std::uint64_t fate_ = 3;  ///< state of the generator that chooses lost datagrams: the same in every run
  std::array<std::uint8_t, kMaxDatagram> block_{}, old_{};
  std::size_t old_size_ = 0;
};

}  // namespace veridyn::dvrk
