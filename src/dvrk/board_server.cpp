#include "veridyn/dvrk/board_server.hpp"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <ctime>

#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

double seconds_now() {
  timespec at{};
  ::clock_gettime(CLOCK_MONOTONIC, &at);
  return static_cast<double>(at.tv_sec) + 1e-9 * static_cast<double>(at.tv_nsec);
}

}  // namespace

BoardServer::BoardServer(BoardEmulator& emulator, std::uint16_t port)
    : emulator_(emulator), start_(seconds_now()) {
  socket_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  other_socket_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_addr.s_addr = htonl(INADDR_ANY);
  at.sin_port = htons(port);
  socklen_t size = sizeof at;
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
}

BoardServer::~BoardServer() {
  ::close(socket_);
  ::close(other_socket_);
}

Ticks BoardServer::now() const {
  return static_cast<Ticks>((seconds_now() - start_) * kTicksPerSecond);
}

void BoardServer::serve(double seconds) {
  pollfd wanted{socket_, POLLIN, 0};
  const timespec most{static_cast<time_t>(seconds),
                      static_cast<long>((seconds - std::floor(seconds)) * 1e9)};
  if (::ppoll(&wanted, 1, &most, nullptr) <= 0) {
    emulator_.advance(now());
  } else {
    std::array<std::uint8_t, kDatagramBuffer> in{}, out{};
    sockaddr_in from{};
    socklen_t size = sizeof from;
    const auto got =
        ::recvfrom(socket_, in.data(), in.size(), 0, reinterpret_cast<sockaddr*>(&from), &size);
    if (got < 0) return;
    const Answer answer = emulator_.handle({in.data(), static_cast<std::size_t>(got)}, now(),
                                           {out.data(), out.size()});
    if (answer.size > 0) {
      if (answer.delay > 0.0) ::usleep(static_cast<useconds_t>(1e6 * answer.delay));
      ::sendto(answer.foreign ? other_socket_ : socket_, out.data(), answer.size, MSG_NOSIGNAL,
               reinterpret_cast<const sockaddr*>(&from), size);
    }
  }
  latest_ = std::max(latest_, static_cast<double>(now() - emulator_.time()) / kTicksPerSecond);
}

void BoardServer::run(const std::atomic<bool>& stop) {
  while (!stop.load(std::memory_order_relaxed)) serve(0.001);
}

}  // namespace veridyn::dvrk
