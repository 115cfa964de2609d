#pragma once

#include <netinet/in.h>
#include <sys/types.h>

#include <cstddef>
#include <ctime>
#include <string>

namespace veridyn {

/// Receives one datagram with its time of arrival in the system; on a busy machine that is well
/// before the call. The socket has the option SO_TIMESTAMPNS.
///
/// @param came  CLOCK_REALTIME; zero without a time stamp of the system.
/// @returns as recvmsg(): number of bytes, truncated at the buffer's end, or -1.
ssize_t receive_stamped(int socket, void* buffer, std::size_t room, sockaddr_in& from,
                        timespec& came) noexcept;

/// [s] since the arrival of a datagram, by its time stamp; 0 without one.
double seconds_since(const timespec& came) noexcept;

/// A UDP port that accepts one sender at a time: the first one, until it has been silent for `silence`.
/// Datagrams of others are not queued meanwhile. Nothing allocates or blocks after the constructor.
class UdpPort {
 public:
  struct Datagram {
    std::size_t size = 0;  ///< bytes, truncated at the buffer's end
    double lay = 0.0;      ///< [s] time between arrival and this call
  };

  /// @param place  "[ADDRESS:]PORT"; without an address this machine's own 127.0.0.1.
  /// @param silence  [s] after which another sender may take the port.
  /// @throws InvalidInput  no IPv4 address, no port, or one in use; `what` begins the message.
  UdpPort(const std::string& place, double silence, const std::string& what);
  ~UdpPort();
  UdpPort(const UdpPort&) = delete;
  UdpPort& operator=(const UdpPort&) = delete;

  /// @returns false: nothing has arrived from the accepted sender.
  bool receive(void* buffer, std::size_t room, Datagram& out) noexcept;

 private:
  bool is_owner(const sockaddr_in& from, double now) noexcept;

  int socket_ = -1;
  double silence_;
  bool owned_ = false;
  sockaddr_in owner_{};
  double heard_ = 0.0;  // [s] time of the last datagram of the accepted sender
};

}  // namespace veridyn
