#include "dvrk/protocol/udp_port.hpp"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr int kMostOthers = 64;  // datagrams of other senders discarded per call

double clock_seconds(clockid_t clock) {
  timespec at{};
  ::clock_gettime(clock, &at);
  return static_cast<double>(at.tv_sec) + 1e-9 * static_cast<double>(at.tv_nsec);
}

sockaddr_in listening_at(const std::string& place, const std::string& what) {
  const auto colon = place.rfind(':');
  const std::string address = colon == std::string::npos ? "127.0.0.1" : place.substr(0, colon);
  const std::string digits = colon == std::string::npos ? place : place.substr(colon + 1);
  char* end = nullptr;
  const long port = std::strtol(digits.c_str(), &end, 10);
  sockaddr_in at{};
  at.sin_family = AF_INET;
  require(!digits.empty() && *end == '\0' && port > 0 && port < 65536, what, ": found the UDP port '",
          digits, "', expected 1 to 65535.");
  require(::inet_pton(AF_INET, address.c_str(), &at.sin_addr) == 1, what, ": UDP ", place, ": found '",
          address, "', expected an IPv4 address of this machine.");
  at.sin_port = htons(static_cast<std::uint16_t>(port));
  return at;
}

}  // namespace

ssize_t receive_stamped(int socket, void* buffer, std::size_t room, sockaddr_in& from,
                        timespec& came) noexcept {
  iovec where{buffer, room};
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(timespec))];
  msghdr message{};
  message.msg_name = &from;
  message.msg_namelen = sizeof from;
  message.msg_iov = &where;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof control;
  came = {};
  const ssize_t got = ::recvmsg(socket, &message, 0);
  if (got < 0) return got;
  for (cmsghdr* one = CMSG_FIRSTHDR(&message); one != nullptr; one = CMSG_NXTHDR(&message, one)) {
    if (one->cmsg_level == SOL_SOCKET && one->cmsg_type == SCM_TIMESTAMPNS)
      std::memcpy(&came, CMSG_DATA(one), sizeof came);
  }
  return got;
}

double seconds_since(const timespec& came) noexcept {
  if (came.tv_sec == 0) return 0.0;
  const double stamp = static_cast<double>(came.tv_sec) + 1e-9 * static_cast<double>(came.tv_nsec);
  return std::max(0.0, clock_seconds(CLOCK_REALTIME) - stamp);
}

UdpPort::UdpPort(const std::string& place, double silence, const std::string& what)
    : silence_(silence) {
  const sockaddr_in at = listening_at(place, what);
  socket_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  require(socket_ >= 0, what, ": found no socket: ", std::strerror(errno), ".");
  const int yes = 1;
  ::setsockopt(socket_, SOL_SOCKET, SO_TIMESTAMPNS, &yes, sizeof yes);
  if (::bind(socket_, reinterpret_cast<const sockaddr*>(&at), sizeof at) == 0) return;
  const std::string why = std::strerror(errno);
  ::close(socket_);
  throw InvalidInput(text(what, ": UDP ", place, ": ", why, "."));
}

UdpPort::~UdpPort() {
  ::close(socket_);
}

// The socket is connected to the accepted sender, so that the system discards datagrams of others.
bool UdpPort::is_owner(const sockaddr_in& from, double now) noexcept {
  if (!owned_) {
    owner_ = from;
    owned_ = true;
    static_cast<void>(::connect(socket_, reinterpret_cast<const sockaddr*>(&owner_), sizeof owner_));
  }
  if (from.sin_addr.s_addr != owner_.sin_addr.s_addr || from.sin_port != owner_.sin_port) return false;
  heard_ = now;
  return true;
}

bool UdpPort::receive(void* buffer, std::size_t room, Datagram& out) noexcept {
  const double now = clock_seconds(CLOCK_MONOTONIC);
  for (int k = 0; k < kMostOthers; ++k) {
    sockaddr_in from{};
    timespec came{};
    const ssize_t got = receive_stamped(socket_, buffer, room, from, came);
    if (got < 0) break;
    if (!is_owner(from, now)) continue;
    out = {static_cast<std::size_t>(got), seconds_since(came)};
    return true;
  }
  if (owned_ && now - heard_ > silence_) {
    sockaddr nobody{};
    nobody.sa_family = AF_UNSPEC;
    static_cast<void>(::connect(socket_, &nobody, sizeof nobody));
    owned_ = false;
  }
  return false;
}

}  // namespace veridyn
