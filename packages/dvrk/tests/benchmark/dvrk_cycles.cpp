#include <arpa/inet.h>
#include <poll.h>
#include <sched.h>
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

// Two emulated boards over loopback at 1 kHz for so many seconds, in turns by a session and by bare
// sockets that send and receive the datagrams of one of its cycles again and do nothing else: how
// many cycles are late, and how much processor time a cycle takes. The bare client is a lower bound
// of any host library.

namespace veridyn::dvrk {
namespace {

constexpr double kPeriod = 1e-3;  // [s]
constexpr double kToPower = 1.0;  // [s] until currents flow
constexpr int kTurns = 11;
constexpr int kPatience = 5;  // [ms] for a reply
constexpr int kMostWaits = 100;

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
  void set_board(int board) noexcept override { link_.set_board(board); }
  void set_hub(int firmware, int board) noexcept override { link_.set_hub(firmware, board); }

  bool copies = false;
  std::vector<Packet> packets;

 private:
  DatagramLink& link_;
};

// Boards and client have a processor each, as they have on a robot: where both share one, a datagram
// that is sent runs the boards before the call returns.
void pin_to_processor(int number) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(number, &set);
  ::sched_setaffinity(0, sizeof set, &set);
}

double seconds_of(clockid_t clock) {
  timespec at{};
  ::clock_gettime(clock, &at);
  return static_cast<double>(at.tv_sec) + 1e-9 * static_cast<double>(at.tv_nsec);
}

double at_share(const std::vector<double>& sorted, double share) {
  return sorted[share * static_cast<double>(sorted.size() - 1)];
}

struct Beat {
  double each = 0.0;  // [s] processor time of a cycle, all of the thread's
  long cycles = 0, late = 0;
  std::vector<double> took;
};

// So many cycles by the machine's clock.
template <typename Cycle>
void run_cycles(double seconds, Beat& out, Cycle&& cycle) {
  const auto cycles = static_cast<std::size_t>(seconds / kPeriod);
  out.took.reserve(out.took.size() + cycles);
  const double cpu = seconds_of(CLOCK_THREAD_CPUTIME_ID);
  double next = seconds_of(CLOCK_MONOTONIC);
  for (std::size_t k = 0; k < cycles; ++k, next += kPeriod) {
    timespec at{static_cast<time_t>(next), static_cast<long>(1e9 * (next - std::floor(next)))};
    ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr);
    const double start = seconds_of(CLOCK_MONOTONIC);
    if (start - next > kPeriod) {
      ++out.late;
      next = start;
    }
    cycle();
    out.took.push_back(seconds_of(CLOCK_MONOTONIC) - start);
  }
  out.each = (seconds_of(CLOCK_THREAD_CPUTIME_ID) - cpu) / static_cast<double>(cycles);
  out.cycles += static_cast<long>(cycles);
}

void print_times(const char* name, Beat& all, std::vector<double>& each) {
  std::sort(all.took.begin(), all.took.end());
  std::sort(each.begin(), each.end());
  std::printf("%-8s %ld cycles, %ld late; took us: median %.0f, 99 %% %.0f, longest %.0f; processor time us a cycle: %.1f (%.1f to %.1f)\n",
              name, all.cycles, all.late, 1e6 * at_share(all.took, 0.5), 1e6 * at_share(all.took, 0.99), 1e6 * all.took.back(),
              1e6 * at_share(each, 0.5), 1e6 * each.front(), 1e6 * each.back());
}

class Bare {
 public:
  Bare(const std::vector<Packet>& packets, std::uint16_t port) : packets_(packets), line_(::socket(AF_INET, SOCK_DGRAM, 0)) {
    board_.sin_family = AF_INET;
    board_.sin_port = htons(port);
    board_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  }
  ~Bare() { ::close(line_); }
  Bare(const Bare&) = delete;
  Bare& operator=(const Bare&) = delete;

  void cycle() {
    for (const Packet& packet : packets_) {
      ::sendto(line_, packet.bytes.data(), packet.bytes.size(), 0, reinterpret_cast<const sockaddr*>(&board_), sizeof board_);
      const double until = seconds_of(CLOCK_MONOTONIC) + packet.pause;
      while (packet.pause > 0.0 && seconds_of(CLOCK_MONOTONIC) < until) {
      }
      for (int k = 0; k < packet.replies; ++k) {
        pollfd waits{line_, POLLIN, 0};
        int left = kMostWaits;  // no reply is left for the next wait, which it would end at once
        while (::poll(&waits, 1, kPatience) <= 0 && --left > 0) {
        }
        if (left > 0) ::recv(line_, reply_.data(), reply_.size(), 0);
      }
    }
  }

 private:
  const std::vector<Packet>& packets_;
  int line_;
  sockaddr_in board_{};
  std::array<std::uint8_t, kDatagramBuffer> reply_{};
};

// Both run in turns, so that other load of the machine affects both alike.
void run(CycleProtocol protocol, const char* name, double seconds) {
  BoardEmulator emulator({Rig::setup(6), Rig::setup(7)});
  BoardServer server(emulator, 0);
  std::atomic<bool> stop{false};
  std::thread thread([&] {
    pin_to_processor(1);
    set_real_time_priority(40);
    server.run(stop);
  });
  {
    UdpLink link("127.0.0.1", server.port());
    Copier copier(link);
    BoardSession session(copier, Rig::options(protocol));
    session.start();
    pin_to_processor(0);
    const bool priority = set_real_time_priority(30);
    std::printf("%s protocol, %s priority\n", name, priority ? "real-time" : "ordinary");
    long invalid = 0;
    const auto cycle = [&] {
      if (!session.update()) ++invalid;
      for (int b = 0; b < 2; ++b)
        for (int c = 0; c < kChannels; ++c) session.set_command(b, c, 33000.0);
      session.commit();
    };
    Beat first, own, least;
    run_cycles(0.1, first, cycle);
    session.power_on();
    run_cycles(kToPower, first, cycle);
    copier.copies = true;
    cycle();
    copier.copies = false;
    int replies = 0;
    double pauses = 0.0;
    for (const Packet& packet : copier.packets) {
      replies += packet.replies;
      pauses += packet.pause;
    }
    std::printf("a cycle: %zu datagrams sent, %d received, %.0f us of pauses\n", copier.packets.size(), replies, 1e6 * pauses);
    Bare sockets(copier.packets, server.port());
    std::vector<double> mine, theirs, ratios;
    for (int k = 0; k < kTurns; ++k) {
      run_cycles(seconds / kTurns, own, cycle);
      run_cycles(seconds / kTurns, least, [&] { sockets.cycle(); });
      mine.push_back(own.each);
      theirs.push_back(least.each);
      ratios.push_back(own.each / least.each);
    }
    std::printf("state at the end: %s; reads that were not valid: %ld\n", describe(session.state()), invalid);
    print_times("session", own, mine);
    print_times("sockets", least, theirs);
    std::sort(ratios.begin(), ratios.end());
    std::printf("processor time, session to sockets, %d turns: median %.2f (%.2f to %.2f)\n", kTurns,
                at_share(ratios, 0.5), ratios.front(), ratios.back());
    session.shutdown();
  }
  stop = true;
  thread.join();
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
