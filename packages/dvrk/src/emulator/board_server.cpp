#include "emulator/board_server.hpp"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <ctime>

#include "dvrk/protocol/datagram_link.hpp"
#include "dvrk/protocol/udp_port.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

constexpr double kUninterrupted = 2e-6;           // [s] largest time between two clock readings without an interruption
constexpr double kLongestQueue = 0.1;             // [s] largest delay of a datagram in the socket

double seconds_of(const timespec& at) {
  return static_cast<double>(at.tv_sec) + 1e-9 * static_cast<double>(at.tv_nsec);
}

double seconds_now(clockid_t clock = CLOCK_MONOTONIC) {
  timespec at{};
  ::clock_gettime(clock, &at);
  return seconds_of(at);
}

// Receives one datagram with its time of arrival [s] (CLOCK_REALTIME); 0 without a time stamp.
ssize_t receive(int socket, ByteSpan buffer, sockaddr_in& from, double& came) {
  timespec at{};
  const ssize_t got = receive_stamped(socket, buffer.data, buffer.size, from, at);
  came = seconds_of(at);
  return got;
}

bool is_loopback(in_addr address) {
  return (ntohl(address.s_addr) >> 24) == 127;
}

// From firmware 9 on hosts send to all boards by multicast (specification 2.3), so the socket joins the
// group on all interfaces.
void join_multicast(int socket, BoardServer::Listens listens) {
  ifaddrs* all = nullptr;
  if (::getifaddrs(&all) != 0) return;
  for (const ifaddrs* one = all; one != nullptr; one = one->ifa_next) {
    if (one->ifa_addr == nullptr || one->ifa_addr->sa_family != AF_INET) continue;
    sockaddr_in own{};
    std::memcpy(&own, one->ifa_addr, sizeof own);
    if (listens == BoardServer::Listens::kHere && !is_loopback(own.sin_addr)) continue;
    ip_mreq group{};
    group.imr_multiaddr.s_addr = htonl(kMulticastGroup);
    group.imr_interface = own.sin_addr;
    // An interface that is down or has no multicast is of no use for a host either.
    ::setsockopt(socket, IPPROTO_IP, IP_ADD_MEMBERSHIP, &group, sizeof group);
  }
  ::freeifaddrs(all);
}

}  // namespace

BoardServer::BoardServer(BoardEmulator& emulator, std::uint16_t port, Listens listens)
    : emulator_(emulator), listens_(listens), start_(seconds_now()) {
  socket_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  other_socket_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_addr.s_addr = htonl(INADDR_ANY);
  at.sin_port = htons(port);
  socklen_t size = sizeof at;
  // One socket receives the boards' address, their broadcast address and their group. Where a
  // socket cannot be bound to the loopback interface, every sender is checked instead.
  constexpr char kLoopback[] = "lo";
  if (listens == Listens::kHere && socket_ >= 0)
    ::setsockopt(socket_, SOL_SOCKET, SO_BINDTODEVICE, kLoopback, sizeof kLoopback);
  const bool bound = socket_ >= 0 && other_socket_ >= 0 &&
                     ::bind(socket_, reinterpret_cast<const sockaddr*>(&at), sizeof at) == 0 &&
                     ::getsockname(socket_, reinterpret_cast<sockaddr*>(&at), &size) == 0;
  if (!bound) {
    const int error = errno;
    if (socket_ >= 0) ::close(socket_);
    if (other_socket_ >= 0) ::close(other_socket_);
    throw InvalidInput(text("UDP port ", port, ": ", std::strerror(error), "."));
  }
  port_ = ntohs(at.sin_port);
  const int yes = 1;
  ::setsockopt(socket_, SOL_SOCKET, SO_TIMESTAMPNS, &yes, sizeof yes);
  join_multicast(socket_, listens);
}

BoardServer::~BoardServer() {
  ::close(socket_);
  ::close(other_socket_);
}

Ticks BoardServer::now() const {
  return static_cast<Ticks>((seconds_now() - start_) * kTicksPerSecond);
}

// Datagrams carry CLOCK_REALTIME. Its offset to the other clock is measured by reading both without an
// interruption in between.
Ticks BoardServer::time_of(double came) {
  const double before = seconds_now();
  const double real = seconds_now(CLOCK_REALTIME);
  const double after = seconds_now();
  if (after - before < kUninterrupted || apart_ == 0.0) apart_ = real - 0.5 * (before + after);
  const double then = std::clamp(came - apart_, after - kLongestQueue, after);
  return static_cast<Ticks>((then - start_) * kTicksPerSecond);
}

void BoardServer::serve(double seconds) {
  pollfd wanted{socket_, POLLIN, 0};
  const timespec most{static_cast<time_t>(seconds),
                      static_cast<long>((seconds - std::floor(seconds)) * 1e9)};
  if (::ppoll(&wanted, 1, &most, nullptr) <= 0) {
    emulator_.advance(now());
  } else if (!serve_one(0, true)) {
    return;
  }
  latest_ = std::max(latest_, static_cast<double>(now() - emulator_.time()) / kTicksPerSecond);
}

// Serves one datagram at time `at`, or at its arrival time, like a board that is never busy. False if there
// was none.
bool BoardServer::serve_one(Ticks at, bool as_it_came) {
  std::array<std::uint8_t, kDatagramBuffer> in{}, out{};
  sockaddr_in from{};
  double came = 0.0;
  const ssize_t got = receive(socket_, {in.data(), in.size()}, from, came);
  if (got < 0) return false;
  if (!accepts_address(ntohl(from.sin_addr.s_addr))) return true;
  if (as_it_came) at = came > 0.0 ? time_of(came) : now();
  const Answer answer =
      emulator_.handle({in.data(), static_cast<std::size_t>(got)}, std::max(at, emulator_.time()),
                       {out.data(), out.size()});
  if (answer.size > 0) {
    if (answer.delay > 0.0 && as_it_came) ::usleep(static_cast<useconds_t>(1e6 * answer.delay));
    ::sendto(answer.foreign ? other_socket_ : socket_, out.data(), answer.size, MSG_NOSIGNAL,
             reinterpret_cast<const sockaddr*>(&from), sizeof from);
  }
  return true;
}

int BoardServer::serve_waiting(Ticks now) {
  int served = 0;
  pollfd wanted{socket_, POLLIN, 0};
  while (::poll(&wanted, 1, 0) > 0 && serve_one(now, false)) ++served;
  emulator_.advance(std::max(now, emulator_.time()));
  return served;
}

void BoardServer::run(const std::atomic<bool>& stop) {
  while (!stop.load(std::memory_order_relaxed)) serve(0.001);
}

}  // namespace veridyn::dvrk
