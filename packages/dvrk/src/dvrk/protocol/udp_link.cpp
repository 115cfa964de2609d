#include "dvrk/protocol/udp_link.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <ctime>

#include "dvrk/protocol/udp_port.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

constexpr double kSpun = 60e-6;                   // [s] shorter waits poll the clock instead of sleeping

// Seconds as a timespec.
timespec to_timespec(double seconds) {
  const double whole = std::floor(seconds);
  return {static_cast<time_t>(whole), static_cast<long>((seconds - whole) * 1e9)};
}

// Socket address of an IPv4 address in host byte order.
sockaddr_in socket_address(std::uint32_t address, std::uint16_t port) {
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_addr.s_addr = htonl(address);
  at.sin_port = htons(port);
  return at;
}

// IPv4 address in host byte order; throws InvalidInput if the name is unknown.
std::uint32_t resolve_host(const std::string& host) {
  addrinfo hints{};
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  const int error = ::getaddrinfo(host.c_str(), nullptr, &hints, &found);
  require(error == 0 && found != nullptr, "host '", host, "': ", ::gai_strerror(error), ".");
  sockaddr_in at{};
  std::memcpy(&at, found->ai_addr, sizeof at);
  ::freeaddrinfo(found);
  return ntohl(at.sin_addr.s_addr);
}

// The address of this machine on the route to `server`, from which multicast is sent as well.
in_addr own_address(std::uint32_t server, std::uint16_t port) {
  sockaddr_in own{};
  const int probe = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (probe < 0) return own.sin_addr;
  const sockaddr_in there = socket_address(server, port);
  socklen_t size = sizeof own;
  if (::connect(probe, reinterpret_cast<const sockaddr*>(&there), sizeof there) == 0)
    ::getsockname(probe, reinterpret_cast<sockaddr*>(&own), &size);
  ::close(probe);
  return own.sin_addr;
}

// Host part of an IPv4 address by its class: specification 1.
std::uint32_t host_part(std::uint32_t address) {
  const std::uint32_t first = address >> 24;
  return first < 128 ? 0x00FFFFFF : first < 192 ? 0x0000FFFF : first < 224 ? 0x000000FF : ~0U;
}

}  // namespace

UdpLink::UdpLink(const std::string& host, std::uint16_t port)
    : port_(port), server_(resolve_host(host)), board_(server_) {
  broadcast_ = server_ | host_part(server_);
  socket_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  require(socket_ >= 0, "no UDP socket: ", std::strerror(errno), ".");
  const int yes = 1;
  ::setsockopt(socket_, SOL_SOCKET, SO_BROADCAST, &yes, sizeof yes);
  ::setsockopt(socket_, SOL_SOCKET, SO_TIMESTAMPNS, &yes, sizeof yes);
  // Replies are accepted only at the address on the route to the boards.
  sockaddr_in own{};
  own.sin_family = AF_INET;
  own.sin_addr = own_address(server_, port_);
  ::setsockopt(socket_, IPPROTO_IP, IP_MULTICAST_IF, &own.sin_addr, sizeof own.sin_addr);
  if (::bind(socket_, reinterpret_cast<const sockaddr*>(&own), sizeof own) == 0) return;
  const int error = errno;
  ::close(socket_);
  require(false, "no UDP socket at this machine's address on the route to '", host, "': ", std::strerror(error), ".");
}

UdpLink::~UdpLink() {
  if (socket_ >= 0) ::close(socket_);
}

bool UdpLink::send(ByteView datagram, Destination to) noexcept {
  const std::uint32_t address = to == Destination::kEveryone    ? broadcast_
                                : to == Destination::kMulticast ? kMulticastGroup
                                                                : board_;
  const sockaddr_in at = socket_address(address, port_);
  const auto sent = ::sendto(socket_, datagram.data, datagram.size, MSG_NOSIGNAL,
                             reinterpret_cast<const sockaddr*>(&at), sizeof at);
  return sent == static_cast<ssize_t>(datagram.size);
}

Arrival UdpLink::receive(ByteSpan buffer, double timeout) noexcept {
  if (timeout > 0.0) {
    pollfd wanted{socket_, POLLIN, 0};
    const timespec most = to_timespec(timeout);
    if (::ppoll(&wanted, 1, &most, nullptr) <= 0) return {};
  }
  sockaddr_in from{};
  timespec came{};
  const ssize_t got = receive_stamped(socket_, buffer.data, buffer.size, from, came);
  if (got < 0) return {};
  const bool known = ntohs(from.sin_port) == port_ && may_answer(ntohl(from.sin_addr.s_addr));
  return {true, static_cast<std::size_t>(got), known, seconds_since(came)};
}

double UdpLink::now() noexcept {
  timespec at{};
  ::clock_gettime(CLOCK_MONOTONIC, &at);
  return static_cast<double>(at.tv_sec) + 1e-9 * static_cast<double>(at.tv_nsec);
}

void UdpLink::wait(double seconds) noexcept {
  if (!(seconds > 0.0)) return;
  if (seconds < kSpun) {  // shorter than any sleep
    for (const double until = now() + seconds; now() < until;) {
    }
    return;
  }
  timespec left = to_timespec(seconds);
  while (::clock_nanosleep(CLOCK_MONOTONIC, 0, &left, &left) == EINTR) {
  }
}

std::uint32_t UdpLink::address_word() const noexcept {
  return __builtin_bswap32(server_);
}

// True if a board may have this address. An unknown hub may be any board; from Rev 9 on its id is in its address.
bool UdpLink::may_answer(std::uint32_t address) const noexcept {
  if (address == server_ || address == board_) return true;
  return !hub_known_ && address - server_ < static_cast<std::uint32_t>(kMaxBoards);
}

void UdpLink::set_board(int board) noexcept {
  board_ = server_ + static_cast<std::uint32_t>(board);
}

void UdpLink::set_hub(int firmware, int board) noexcept {
  hub_known_ = true;
  board_ = firmware >= 9 ? server_ + static_cast<std::uint32_t>(board) : server_;
}

}  // namespace veridyn::dvrk
