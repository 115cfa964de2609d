#pragma once

#include <cstdint>
#include <string>

#include "veridyn/dvrk/protocol/datagram_link.hpp"
#include "veridyn/dvrk/protocol/protocol.hpp"

namespace veridyn::dvrk {

/// Boards behind an Ethernet port: specification 1 and 2.3. "Everyone" is the broadcast address for the class of
/// the server's address; for 127.0.0.1 that is 127.255.255.255. An emulator must listen on all addresses to
/// receive both.
class UdpLink final : public DatagramLink {
 public:
  /// @param host  IPv4 address or name; boards have 169.254.0.100 by default.
  /// @throws InvalidInput  the host is unknown, or no socket is available.
  explicit UdpLink(const std::string& host, std::uint16_t port = kUdpPort);
  ~UdpLink() override;
  UdpLink(const UdpLink&) = delete;
  UdpLink& operator=(const UdpLink&) = delete;

  bool send(ByteView datagram, Destination to) noexcept override;
  Arrival receive(ByteSpan buffer, double timeout) noexcept override;
  double now() noexcept override;
  void wait(double seconds) noexcept override;
  std::uint32_t address_word() const noexcept override;
  void set_hub(int firmware, int board) noexcept override;
  void set_board(int board) noexcept override;

 private:
  bool may_answer(std::uint32_t address) const noexcept;

  int socket_ = -1;
  std::uint16_t port_;
  std::uint32_t server_ = 0;  ///< host byte order
  std::uint32_t board_ = 0;
  std::uint32_t broadcast_ = 0;
  bool hub_known_ = false;
};

}  // namespace veridyn::dvrk
