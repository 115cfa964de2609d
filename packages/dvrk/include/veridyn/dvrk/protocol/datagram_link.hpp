#pragma once

#include <cstddef>
#include <cstdint>

#include "veridyn/dvrk/protocol/bytes.hpp"

namespace veridyn::dvrk {

inline constexpr std::uint32_t kMulticastGroup = 0xE0000064;  ///< 224.0.0.100, section 1

/// Destination of a datagram: specification 2.3.
enum class Destination { kBoard, kEveryone, kMulticast };

/// A received datagram.
struct Arrival {
  bool any = false;
  std::size_t size = 0;      ///< bytes, cut at the buffer's end
  bool known_source = true;  ///< true if its source is an address of the boards
  double lay = 0.0;          ///< [s] time between its arrival and its receipt by this program
};

/// The connection to the boards, with its clock: UDP, or an emulator in the same process with a
/// clock that tests advance.
class DatagramLink {
 public:
  virtual ~DatagramLink() = default;

  /// @returns false: it could not be sent.
  virtual bool send(ByteView datagram, Destination to) noexcept = 0;
  /// Waits up to `timeout` [s]; 0 polls.
  virtual Arrival receive(ByteSpan buffer, double timeout) noexcept = 0;
  virtual double now() noexcept = 0;  ///< [s], never decreases
  virtual void wait(double seconds) noexcept = 0;
  /// The server's IPv4 address in the form of register 11: a.b.c.d is 0xddccbbaa (specification 5).
  virtual std::uint32_t address_word() const noexcept = 0;
  /// From now on Destination::kBoard means the board with this id, on a bus without FireWire.
  virtual void set_board(int board) noexcept { (void)board; }
  /// Sets the hub that was found; from Rev 9 on its board id is part of its address (specification 2.3).
  virtual void set_hub(int firmware, int board) noexcept {
    (void)firmware;
    (void)board;
  }
};

}  // namespace veridyn::dvrk
