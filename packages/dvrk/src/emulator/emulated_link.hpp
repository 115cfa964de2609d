#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "emulator/board_emulator.hpp"
#include "dvrk/protocol/datagram_link.hpp"

namespace veridyn::dvrk {

/// A link to an emulator in the same process. Its clock advances only while a caller waits, or by
/// advance(), so that tests of seconds run in microseconds. The emulator is not owned.
class EmulatedLink final : public DatagramLink {
 public:
  explicit EmulatedLink(BoardEmulator& emulator) : emulator_(emulator) {}

  bool send(ByteView datagram, Destination to) noexcept override;
  Arrival receive(ByteSpan buffer, double timeout) noexcept override;
  double now() noexcept override { return static_cast<double>(ticks_) / kTicksPerSecond; }
  void wait(double seconds) noexcept override { advance(seconds); }
  std::uint32_t address_word() const noexcept override { return 0x0100007F; }

  void advance(double seconds) noexcept;

  /// Queues an unsolicited datagram, which arrives now; it is dropped if the queue is full.
  void push(ByteView datagram, bool known_source = true) noexcept;

  bool cut = false;           ///< sends fail
  double round_trip = 50e-6;  ///< [s] from a request to its answer

 private:
  struct Waiting {
    std::array<std::uint8_t, kDatagramBuffer> bytes{};
    std::size_t size = 0;
    Ticks at = 0;
    bool known = true;
  };

  Waiting* oldest() noexcept;  ///< the datagram that arrives first; nullptr: none
  Waiting* free_slot() noexcept;  ///< nullptr: the queue is full

  BoardEmulator& emulator_;
  Ticks ticks_ = 0;
  std::array<Waiting, 8> queue_{};
};

}  // namespace veridyn::dvrk
