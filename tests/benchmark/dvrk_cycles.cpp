#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <thread>
#include <vector>

#include "emulator/board_server.hpp"
#include "dvrk/protocol/udp_link.hpp"
#include "dvrk/rig.hpp"
#include "veridyn/control/real_time.hpp"

// Two emulated boards over loopback at 1 kHz for so many seconds, by a session, and by bare sockets
// that send and receive the datagrams of one of its cycles again and do nothing else: how many
// cycles are late, and how much processor time a cycle takes. The bare client is a lower bound of
// any host library.

namespace veridyn::dvrk {
namespace {

constexpr double kPeriod = 1e-3;  // [s]
constexpr std::size_t kCopied = 1500;  // the cycle whose datagrams are sent again

struct Packet {
  std::vector<std::uint8_t> bytes;
  Destination to = Destination::kBoard;
  int replies = 0;
  double pause = 0.0;  // [s] that the protocol leaves the boards after it
};

// Keeps the datagrams of one cycle.
class Copier final : public DatagramLink {
 public:
  explicit Copier(DatagramLink& link) : link_(link) {}
  bool send(ByteView datagram, Destination to) noexcept override {
    if (copies) packets.push_back({{datagram.data, datagram.data + datagram.size}, to, 0, 0.0});
    return link_.send(datagram, to);
  }
  Arrival receive(ByteSpan buffer, double timeout) noexcept override {
    const Arrival arrival = link_.receive(buffer, timeout);
    if (copies && arrival.any && !packets.empty()) ++packets.back().replies;
    return arrival;
  }
  double now() noexcept override { return link_.now(); }
  void wait(double seconds) noexcept override {
    if (copies && !packets.empty()) packets.back().pause += std::max(0.0, seconds);
    link_.wait(seconds);
  }
  std::uint32_t address_word() const noexcept override { return link_.address_word(); }
  void speak_to(int board) noexcept override { link_.speak_to(board); }
  void hub_is(int firmware, int board) noexcept override { link_.hub_is(firmware, board); }

  bool copies = false;
  std::vector<Packet> packets;

 private:
  DatagramLink& link_;
};

double seconds_of(clockid_t clock) {
  timespec at{};
  ::clock_gettime(clock, &at);
  return static_cast<double>(at.tv_sec) + 1e-9 * static_cast<double>(at.tv_nsec);
}

double at_share(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

// So many cycles by the machine's clock. @returns processor time per cycle [s], all of the thread's.
template <typename Cycle>
double beat(const char* name, double seconds, Cycle&& cycle) {
  const auto cycles = static_cast<std::size_t>(seconds / kPeriod);
  std::vector<double> took;
  took.reserve(cycles);
  long late = 0;
  const double cpu = seconds_of(CLOCK_THREAD_CPUTIME_ID);
  double next = seconds_of(CLOCK_MONOTONIC);
  for (std::size_t k = 0; k < cycles; ++k, next += kPeriod) {
    timespec at{static_cast<time_t>(next), static_cast<long>(1e9 * (next - std::floor(next)))};
    ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr);
    const double start = seconds_of(CLOCK_MONOTONIC);
    if (start - next > kPeriod) {
      ++late;
      next = start;
    }
    cycle(k);
    took.push_back(seconds_of(CLOCK_MONOTONIC) - start);
  }
  const double each = (seconds_of(CLOCK_THREAD_CPUTIME_ID) - cpu) / static_cast<double>(cycles);
  std::sort(took.begin(), took.end());
  std::printf("%-8s %zu cycles, %ld late; took us: median %.0f, 99 %% %.0f, longest %.0f; processor time %.1f us a cycle\n",
              name, cycles, late, 1e6 * at_share(took, 0.5), 1e6 * at_share(took, 0.99), 1e6 * took.back(), 1e6 * each);
  return each;
}

double bare(const std::vector<Packet>& packets, std::uint16_t port, double seconds) {
  const int line = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in board{};
  board.sin_family = AF_INET;
  board.sin_port = htons(port);
  board.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  std::array<std::uint8_t, kDatagramBuffer> reply{};
  const double each = beat("sockets", seconds, [&](std::size_t) {
    for (const Packet& packet : packets) {
      ::sendto(line, packet.bytes.data(), packet.bytes.size(), 0, reinterpret_cast<const sockaddr*>(&board), sizeof board);
      const double until = seconds_of(CLOCK_MONOTONIC) + packet.pause;
      while (packet.pause > 0.0 && seconds_of(CLOCK_MONOTONIC) < until) {
      }
      for (int k = 0; k < packet.replies; ++k) {
        pollfd waits{line, POLLIN, 0};
        if (::poll(&waits, 1, 5) > 0) ::recv(line, reply.data(), reply.size(), 0);
      }
    }
  });
  ::close(line);
  return each;
}

void run(CycleProtocol protocol, const char* name, double seconds) {
  BoardEmulator emulator({Rig::setup(6), Rig::setup(7)});
  BoardServer server(emulator, 0);
  std::atomic<bool> stop{false};
  std::thread thread([&] {
    take_real_time_priority(40);
    server.run(stop);
  });
  double own = 0.0, least = 0.0;
  {
    UdpLink link("127.0.0.1", server.port());
    Copier copier(link);
    BoardSession session(copier, Rig::options(protocol));
    session.start();
    const bool priority = take_real_time_priority(30);
    std::printf("%s protocol, %s priority\n", name, priority ? "real-time" : "ordinary");
    long invalid = 0;
    own = beat("session", seconds, [&](std::size_t k) {
      copier.copies = k == kCopied;
      if (!session.update()) ++invalid;
      for (int b = 0; b < 2; ++b)
        for (int c = 0; c < kChannels; ++c) session.set_command(b, c, 33000.0);
      session.commit();
      if (k == 100) session.power_on();
    });
    std::printf("state at the end: %s; reads that were not valid: %ld\n%s", describe(session.state()), invalid,
                session.faults().report().c_str());
    session.shutdown();
    int replies = 0;
    double pauses = 0.0;
    for (const Packet& packet : copier.packets) {
      replies += packet.replies;
      pauses += packet.pause;
    }
    std::printf("a cycle: %zu datagrams sent, %d received, %.0f us of pauses\n", copier.packets.size(), replies, 1e6 * pauses);
    least = bare(copier.packets, server.port(), seconds);
  }
  stop = true;
  thread.join();
  std::printf("processor time, session to sockets: %.2f\n", own / least);
}

}  // namespace
}  // namespace veridyn::dvrk

int main(int argc, char** argv) {
  const double seconds = argc > 1 ? std::atof(argv[1]) : 20.0;
  if (!(seconds >= 2.0)) {
    std::fprintf(stderr, "found %s, expected 2 s or more\n", argv[1]);
    return 2;
  }
  veridyn::dvrk::run(veridyn::dvrk::CycleProtocol::kSequential, "sequential", seconds);
  veridyn::dvrk::run(veridyn::dvrk::CycleProtocol::kBroadcast, "broadcast", seconds);
}
