#pragma once

#include <netinet/in.h>
#include <sys/types.h>

#include <cstddef>
#include <ctime>
#include <string>

namespace veridyn {

/// One datagram, and when the system got it; on a busy machine that is well before now. The socket
/// has the option SO_TIMESTAMPNS.
///
/// @param came  CLOCK_REALTIME; zero where the system put no stamp on it.
/// @returns as recvmsg(): bytes, cut at the buffer's end, or -1.
ssize_t receive_stamped(int socket, void* buffer, std::size_t room, sockaddr_in& from,
                        timespec& came) noexcept;

/// [s] for which a datagram lay ready, by the stamp that the system put on it; 0 without one.
double seconds_since(const timespec& came) noexcept;

/// A UDP port that listens to one sender: the first one owns it until it is silent for long enough.
/// Datagrams of others are not even queued then. Nothing allocates or blocks after the constructor.
class UdpPort {
 public:
  struct Datagram {
    std::size_t size = 0;  ///< bytes, cut at the buffer's end
    double lay = 0.0;      ///< [s] for which it lay ready before it was taken
  };

  /// @param place  "[ADDRESS:]PORT"; without an address this machine's own 127.0.0.1.
  /// @param silence  [s] after which another sender may own the port.
  /// @throws InvalidInput  no IPv4 address, no port, one that is taken; `what` begins the message.
  UdpPort(const std::string& place, double silence, const std::string& what);
  ~UdpPort();
  UdpPort(const UdpPort&) = delete;
  UdpPort& operator=(const UdpPort&) = delete;

  /// @returns false: nothing has come from the owner.
  bool receive(void* buffer, std::size_t room, Datagram& out) noexcept;

 private:
  bool is_owner(const sockaddr_in& from, double now) noexcept;

  int socket_ = -1;
  double silence_;
  bool owned_ = false;
  sockaddr_in owner_{};
  double heard_ = 0.0;  // [s] the owner
};

}  // namespace veridyn
