#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <thread>
#include <vector>

#include "dvrk/rig.hpp"
#include "emulator/board_server.hpp"
#include "veridyn/control/real_time.hpp"
#include "dvrk/protocol/udp_link.hpp"

// Two emulated boards over loopback, broadcast protocol, at 1.5 kHz for so many seconds: which
// cycles were missed, and by whom. A cycle is missed by the machine if it woke us late, by us if
// our own work took longer than a period.

namespace veridyn::dvrk {
namespace {

constexpr double kPeriod = 1.0 / 1500.0;

double cpu_seconds() {
  timespec at{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &at);
  return static_cast<double>(at.tv_sec) + 1e-9 * static_cast<double>(at.tv_nsec);
}

double at_share(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<size_t>(share * static_cast<double>(sorted.size() - 1))];
}

int run(double seconds) {
  BoardEmulator emulator({Rig::setup(6), Rig::setup(7)});
  BoardServer server(emulator, 0);
  std::atomic<bool> stop{false};
  bool priority = false;
  std::thread thread([&] {
    take_real_time_priority(40);
    server.run(stop);
  });
  std::vector<double> took, worked;
  long woken_late = 0, invalid = 0, slow = 0;
  std::string faults;
  {
    UdpLink link("127.0.0.1", server.port());
    SessionOptions options = Rig::options(CycleProtocol::kBroadcast);
    BoardSession session(link, options);
    session.start();
    priority = take_real_time_priority(30);
    const auto cycles = static_cast<size_t>(seconds / kPeriod);
    took.reserve(cycles);
    worked.reserve(cycles);
    double next = link.now();
    for (size_t k = 0; k < cycles; ++k) {
      link.wait(next - link.now());
      const double start = link.now();
      const double cpu = cpu_seconds();
      if (start - next > kPeriod) {
        ++woken_late;
        next = start;
      }
      if (!session.update()) ++invalid;
      for (int b = 0; b < 2; ++b) {
        for (int c = 0; c < kChannels; ++c) session.set_command(b, c, 33000.0);
      }
      session.commit();
      if (k == 100) session.power_on();
      const double end = link.now();
      took.push_back(end - start);
      worked.push_back(cpu_seconds() - cpu);
      if (worked.back() > kPeriod) ++slow;
      next += kPeriod;
    }
    faults = session.faults().report();
    std::printf("state at the end: %s\n", describe(session.state()));
  }
  stop = true;
  thread.join();
  std::sort(took.begin(), took.end());
  std::sort(worked.begin(), worked.end());
  std::printf("%zu cycles of 1500 Hz, two boards, broadcast protocol, %s priority\n", took.size(),
              priority ? "real-time" : "ordinary");
  std::printf(
      "missed because we were woken late: %ld; our own work beyond a period: %ld; "
      "reads that were not valid: %ld\n",
      woken_late, slow, invalid);
  std::printf("a cycle took, us: median %.1f, 99 %% %.1f, 99.9 %% %.1f, longest %.1f\n",
              1e6 * at_share(took, 0.5), 1e6 * at_share(took, 0.99), 1e6 * at_share(took, 0.999),
              1e6 * took.back());
  std::printf("processor time of a cycle, us: median %.1f, 99.9 %% %.1f, longest %.1f\n%s",
              1e6 * at_share(worked, 0.5), 1e6 * at_share(worked, 0.999), 1e6 * worked.back(),
              faults.c_str());
  return slow == 0 ? 0 : 1;
}

}  // namespace
}  // namespace veridyn::dvrk

int main(int argc, char** argv) {
  const double seconds = argc > 1 ? std::atof(argv[1]) : 60.0;
  if (!(seconds > 1.0)) {
    std::fprintf(stderr, "expected seconds, more than 1\n");
    return 2;
  }
  return veridyn::dvrk::run(seconds);
}
