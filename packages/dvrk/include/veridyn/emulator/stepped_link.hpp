#pragma once

#include "veridyn/dvrk/protocol/udp_link.hpp"

namespace veridyn::dvrk {

/// A clock that the tested loop advances, and emulated boards that use it.
class SteppedClock {
 public:
  virtual ~SteppedClock() = default;
  virtual double now() const = 0;  ///< [s] present time
  /// Answers all datagrams in the boards' sockets at the present time.
  virtual void serve() = 0;
  /// The same, then advances the time.
  virtual void pass(double seconds) = 0;
};

/// UDP sockets like UdpLink's, with a SteppedClock: time stops while this program computes, so that a run is
/// independent of the machine's speed and load. A reply takes kRoundTrip; a missing one takes the whole
/// timeout.
class SteppedLink final : public DatagramLink {
 public:
  static constexpr double kRoundTrip = 50e-6;  ///< [s] from a request to its reply

  /// @throws InvalidInput  as UdpLink.
  SteppedLink(std::uint16_t port, SteppedClock& clock) : udp_("127.0.0.1", port), clock_(clock) {}

  bool send(ByteView datagram, Destination to) noexcept override { return udp_.send(datagram, to); }
  Arrival receive(ByteSpan buffer, double timeout) noexcept override {
    clock_.serve();
    Arrival arrival = udp_.receive(buffer, 0.0);
    if (timeout > 0.0) clock_.pass(arrival.any ? kRoundTrip : timeout);
    if (!arrival.any && timeout > 0.0) arrival = udp_.receive(buffer, 0.0);
    arrival.lay = 0.0;
    return arrival;
  }
  double now() noexcept override { return clock_.now(); }
  void wait(double seconds) noexcept override { clock_.pass(seconds); }
  std::uint32_t address_word() const noexcept override { return udp_.address_word(); }
  void set_board(int board) noexcept override { udp_.set_board(board); }
  void set_hub(int firmware, int board) noexcept override { udp_.set_hub(firmware, board); }

 private:
  UdpLink udp_;
  SteppedClock& clock_;
};

}  // namespace veridyn::dvrk
