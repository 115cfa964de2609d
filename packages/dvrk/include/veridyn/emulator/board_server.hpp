#pragma once

#include <atomic>
#include <cstdint>

#include "veridyn/emulator/board_emulator.hpp"

namespace veridyn::dvrk {

/// An emulator behind a UDP port, in real time. Clients also send to a broadcast address and to a group
/// (specification 1 and 2.3), so that it has to listen on more than one address.
class BoardServer {
 public:
  enum class Listens {
    kHere,       ///< listens only to programs on this machine
    kEverywhere  ///< listens on all addresses of the machine
  };

  /// @param port  0: any free one, see port(). Real hosts only use 1394.
  /// @throws InvalidInput  the port is in use.
  BoardServer(BoardEmulator& emulator, std::uint16_t port, Listens listens = Listens::kHere);
  ~BoardServer();
  BoardServer(const BoardServer&) = delete;
  BoardServer& operator=(const BoardServer&) = delete;

  std::uint16_t port() const { return port_; }

  /// True if datagrams from this address are accepted, in host byte order.
  bool accepts_address(std::uint32_t address) const {
    return listens_ == Listens::kEverywhere || (address >> 24) == 127;
  }

  /// Serves until `stop` is true. Meanwhile only this thread may use the emulator.
  void run(const std::atomic<bool>& stop);
  /// Waits up to `seconds` for one datagram and answers it; the arm moves in any case.
  void serve(double seconds);

  /// Answers all waiting datagrams without blocking, with an external clock. @returns the number of
  /// datagrams. @param now  never decreases.
  int serve_waiting(Ticks now);

  /// [s] largest delay of the arm since the server was created, because its simulation was slower than real
  /// time.
  double latest() const { return latest_; }

 private:
  Ticks now() const;  ///< since the constructor
  Ticks time_of(double came);  ///< of CLOCK_REALTIME [s], at most 0.1 s ago
  bool serve_one(Ticks at, bool as_it_came);

  BoardEmulator& emulator_;
  Listens listens_;
  int socket_ = -1;
  int other_socket_ = -1;  ///< socket for replies from an unknown address
  std::uint16_t port_ = 0;
  double start_ = 0.0;
  double latest_ = 0.0;
  double apart_ = 0.0;  ///< [s] CLOCK_REALTIME minus CLOCK_MONOTONIC
};

}  // namespace veridyn::dvrk
