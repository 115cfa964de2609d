#include "dvrk/udp_proxy.hpp"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <ctime>
#include <stdexcept>

namespace veridyn::dvrk {
namespace {

double seconds_now() {
  timespec at{};
  ::clock_gettime(CLOCK_MONOTONIC, &at);
  return static_cast<double>(at.tv_sec) + 1e-9 * static_cast<double>(at.tv_nsec);
}

}  // namespace

UdpProxy::UdpProxy(std::uint16_t server, std::uint64_t seed) : server_(server), fate_(seed) {
  socket_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  sockaddr_in at{};
  at.sin_family = AF_INET;
  socklen_t size = sizeof at;
  if (socket_ < 0 || ::bind(socket_, reinterpret_cast<const sockaddr*>(&at), sizeof at) != 0 ||
      ::getsockname(socket_, reinterpret_cast<sockaddr*>(&at), &size) != 0)
    throw std::runtime_error("no UDP port for the proxy");
  port_ = ntohs(at.sin_port);
  thread_ = std::thread([this] { run(); });
}

UdpProxy::~UdpProxy() {
  stop_ = true;
  thread_.join();
  for (const auto& client : clients_) ::close(client.second.first);
  ::close(socket_);
}

void UdpProxy::set(const Mischief& up, const Mischief& down) {
  const std::lock_guard<std::mutex> lock(mutex_);
  up_ = up;
  down_ = down;
}

void UdpProxy::pass_up() {
  std::uint8_t buffer[4096];
  sockaddr_in from{};
  socklen_t size = sizeof from;
  ssize_t got = 0;
  while ((got = ::recvfrom(socket_, buffer, sizeof buffer, 0, reinterpret_cast<sockaddr*>(&from),
                           &size)) >= 0) {
    const ByteView datagram{buffer, static_cast<std::size_t>(got)};
    ++(is_write(datagram) ? writes_ : reads_);
    const std::uint64_t key = (std::uint64_t{from.sin_addr.s_addr} << 16) | from.sin_port;
    auto& client = clients_[key];
    if (client.first <= 0)
      client = {::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0), from};
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    to.sin_port = htons(server_);
    for (Copy& copy : fate_.of(datagram, up_))
      held_.push_back({std::move(copy.bytes), seconds_now() + copy.delay, client.first, to});
  }
}

void UdpProxy::pass_down(int socket, const sockaddr_in& client) {
  std::uint8_t buffer[4096];
  ssize_t got = 0;
  while ((got = ::recv(socket, buffer, sizeof buffer, 0)) >= 0) {
    for (Copy& copy : fate_.of({buffer, static_cast<std::size_t>(got)}, down_))
      held_.push_back({std::move(copy.bytes), seconds_now() + copy.delay, socket_, client});
  }
}

void UdpProxy::send_due() {
  const double now = seconds_now();
  for (auto one = held_.begin(); one != held_.end();) {
    if (one->at > now) {
      ++one;
      continue;
    }
    ::sendto(one->from, one->bytes.data(), one->bytes.size(), MSG_NOSIGNAL,
             reinterpret_cast<const sockaddr*>(&one->to), sizeof one->to);
    one = held_.erase(one);
  }
}

void UdpProxy::run() {
  while (!stop_) {
    std::vector<pollfd> wanted{{socket_, POLLIN, 0}};
    for (const auto& client : clients_) wanted.push_back({client.second.first, POLLIN, 0});
    const timespec most{0, held_.empty() ? 1'000'000 : 50'000};
    ::ppoll(wanted.data(), wanted.size(), &most, nullptr);
    const std::lock_guard<std::mutex> lock(mutex_);
    pass_up();
    for (const auto& client : clients_) pass_down(client.second.first, client.second.second);
    send_due();
  }
}

}  // namespace veridyn::dvrk
