#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "veridyn/dvrk/protocol/bytes.hpp"
#include "veridyn/dvrk/protocol/datagram_link.hpp"
#include "veridyn/dvrk/protocol/fault_log.hpp"
#include "veridyn/dvrk/protocol/protocol.hpp"
#include "veridyn/dvrk/protocol/reply.hpp"
#include "veridyn/dvrk/protocol/request.hpp"

namespace veridyn::dvrk {

/// Board and route.
struct Route {
  std::uint8_t node = kBroadcastNode;
  bool local = false;  ///< NOFORWARD: only the receiving board
  Destination to = Destination::kBoard;
  std::optional<int> board = {};  ///< Ethernet-only: the board with its own address (specification 2.3)
};

enum class ReadResult {
  kOk,
  kNotSent,
  kNoReply,
  kWrongSize,
  kWrongHeader,
  kWrongCrc,  ///< a nonzero CRC that is wrong
  kDropped    ///< the board answered with only a trailer
};

/// The condition of section 17 for a read that failed; kNoReply for kOk.
Condition condition_of(ReadResult result);

/// Number of the last kRequests requests whose first reply was lost or late.
struct ReplyLoss {
  static constexpr long kRequests = 3000;  ///< number of requests over which `lost` counts; 1 s of two boards at 1.5 kHz
  /// Bound of `lost`: 1 % of loss each way gives 60 +- 8, 5 % of the replies alone 150 +- 12.
  static constexpr long kMost = 105;
  long lost = 0;
  bool too_many() const noexcept { return lost > kMost; }
};

/// Reads and writes of one session, one at a time: labels, generation, matching of replies,
/// trailers. Detects conditions 1 to 8 and 28 to 30. Fixed buffers.
class Exchange {
 public:
  Exchange(DatagramLink& link, FaultLog& log) : link_(link), log_(log) {}

  /// @param timeout  [s] for the reply.
  ReadResult read(const Route& route, std::uint16_t address, double timeout, std::uint32_t& value) noexcept;
  /// @param block  valid until the next read.
  ReadResult read_block(const Route& route, std::uint16_t address, std::size_t quadlets,
                        double timeout, QuadletView& block) noexcept;
  /// @returns false: not sent. Boards never acknowledge a write.
  bool write(const Route& route, std::uint16_t address, std::uint32_t value) noexcept;
  bool write_block(const Route& route, std::uint16_t address, QuadletView block) noexcept;

  std::uint8_t generation() const { return generation_; }
  /// A trailer had another generation than ours: node numbers may have changed.
  bool generation_changed() const { return learnt_ && told_ != generation_; }
  void adopt_generation() noexcept { generation_ = told_; }  ///< requests use the generation of the last trailer
  /// While set, a missing reply is no fault, because a scan addresses nodes that may not exist.
  void expect_silence(bool expected) noexcept { silence_expected_ = expected; }
  /// [s] after which a request without a reply is repeated, again after twice as long, and so on until the
  /// timeout; 0: never. The first time is 5 ms if no reply was missed for 10 s. A board executes the read
  /// each time; the first reply is used.
  void repeat_after(double seconds) noexcept { repeat_after_ = seconds; }
  /// From now on write() and write_block() send nothing and report success. A query of the hub may
  /// be an exception: it changes no output of a board, but keeps its watchdog alive.
  enum class Queries { kNone, kAllowed };
  void listen_only(Queries queries) noexcept {
    listens_ = true;
    queries_ = queries == Queries::kAllowed;
  }
  const ReplyLoss& loss() const { return loss_; }
  /// [s] for which replies waited in the socket, since reset_queue_delay().
  double queue_delay() const { return lay_; }
  void reset_queue_delay() noexcept { lay_ = 0.0; }
  /// True if the last trailer reported a bus reset in progress.
  bool resetting() const { return resetting_; }

 private:
  /// A request with the next label and the present generation, without data.
  Request request(const Route& route, Tcode tcode, std::uint16_t address) noexcept;
  bool send(const Request& request, const Route& route) noexcept;  ///< false: not sent, which is logged
  void drain() noexcept;
  /// @param timeout  [s], repeats of the request included. A failure is logged.
  ReadResult read(const Request& request, const Route& route, double timeout, Reply& reply) noexcept;
  /// @param until  [s] of the link's clock. @returns kNoReply, without an entry in the log, if nothing came.
  ReadResult await(const Request& request, double until, Reply& reply) noexcept;
  bool answers_repeated(ByteView datagram) const noexcept;
  ReadResult classify_reply(const Request& request, ByteView datagram, Malformed malformed,
                   const Reply& reply) noexcept;
  void read_trailer(const Trailer& trailer) noexcept;
  void count_request() noexcept;

  DatagramLink& link_;
  FaultLog& log_;
  std::uint8_t label_ = 0;
  std::uint8_t generation_ = 0;
  std::uint8_t told_ = 0;
  bool learnt_ = false;
  bool resetting_ = false;
  bool silence_expected_ = false;
  bool listens_ = false;
  bool queries_ = false;
  double repeat_after_ = 0.0;
  double wary_until_ = 0.0;  // [s] link's clock, until which requests are repeated sooner
  std::optional<int> repeated_ = {};  ///< label of the last request that was sent twice, which may be answered twice
  std::size_t sent_ = 0;  ///< bytes of the last request in out_
  double lay_ = 0.0;
  ReplyLoss loss_;
  long requests_ = 0, lost_ = 0;  // counts of the present window, see ReplyLoss
  std::optional<int> packet_errors_ = {};
  std::array<std::uint8_t, kDatagramBuffer> out_{};
  std::array<std::uint8_t, kDatagramBuffer> in_{};
};

}  // namespace veridyn::dvrk
