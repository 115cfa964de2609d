#include <gtest/gtest.h>

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <new>

#include "dvrk/mutator.hpp"
#include "dvrk/packet_probe.hpp"
#include "dvrk/rig.hpp"
#include "dvrk/vectors.hpp"
#include "dvrk/protocol/protocol.hpp"

// Mutated datagrams, each in front of an unreadable page: a byte read beyond the end ends
// the test, with or without a sanitizer.

namespace veridyn::dvrk {
namespace {

class GuardedBuffer {
 public:
  GuardedBuffer() {
    page_ = static_cast<size_t>(::sysconf(_SC_PAGESIZE));
    room_ = 2 * page_;
    void* at =
        ::mmap(nullptr, room_ + page_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (at == MAP_FAILED) throw std::bad_alloc();
    begin_ = static_cast<std::uint8_t*>(at);
    ::mprotect(begin_ + room_, page_, PROT_NONE);
  }
  ~GuardedBuffer() { ::munmap(begin_, room_ + page_); }
  GuardedBuffer(const GuardedBuffer&) = delete;
  GuardedBuffer& operator=(const GuardedBuffer&) = delete;

  // The bytes, ending where the forbidden page begins.
  ByteView place_before_guard_page(const std::uint8_t* bytes, size_t size) {
    std::uint8_t* at = begin_ + room_ - size;
    std::memcpy(at, bytes, size);
    return {at, size};
  }

 private:
  size_t page_ = 0, room_ = 0;
  std::uint8_t* begin_ = nullptr;
};

TEST(MutatedDatagrams, AreDecodedWithoutReadingBeyondTheirEnd) {
  GuardedBuffer buffer;
  Mutator mutator(19);
  for (long k = 0; k < 2000000; ++k) {
    const std::vector<std::uint8_t>& bytes = mutator.next();
    const char* wrong = probe_packet(buffer.place_before_guard_page(bytes.data(), bytes.size()));
    ASSERT_EQ(wrong, nullptr) << wrong << ", mutation " << k << ": "
                              << hex_of({bytes.data(), bytes.size()});
  }
}

TEST(MutatedDatagrams, EveryTruncatedPacketIsDecodedWithoutReadingBeyondItsEnd) {
  GuardedBuffer buffer;
  for (const Vector& v : vectors()) {
    const std::vector<std::uint8_t> bytes = bytes_of(v.hex);
    for (size_t size = 0; size <= bytes.size(); ++size)
      EXPECT_EQ(probe_packet(buffer.place_before_guard_page(bytes.data(), size)), nullptr);
  }
}

// A board answers with a valid reply or not at all; for any input its currents stay within
// the commands of well-formed datagrams.
TEST(MutatedDatagrams, DoNotCrashTheEmulator) {
  GuardedBuffer buffer;
  Mutator mutator(18);
  BoardEmulator emulator({Rig::setup(6), Rig::setup(7)}, 3);
  std::array<std::uint8_t, kDatagramBuffer> out{};
  Ticks now = 0;
  long answers = 0;
  for (long k = 0; k < 300000; ++k) {
    const std::vector<std::uint8_t>& bytes = mutator.next();
    now += 1000;
    const Answer answer =
        emulator.handle(buffer.place_before_guard_page(bytes.data(), bytes.size()), now, {out.data(), out.size()});
    if (answer.size == 0) continue;
    Reply reply;
    ASSERT_EQ(decode({out.data(), answer.size}, reply), Malformed::kNone) << k;
    ++answers;
  }
  EXPECT_GT(answers, 1000);
  EXPECT_GT(emulator.counters().malformed, 1000);
}

// Replies are changed at random in transit.
class HostileLink final : public DatagramLink {
 public:
  explicit HostileLink(DatagramLink& link) : link_(link) {}
  bool send(ByteView datagram, Destination to) noexcept override {
    return link_.send(datagram, to);
  }
  Arrival receive(ByteSpan buffer, double timeout) noexcept override {
    Arrival arrival = link_.receive(buffer, timeout);
    if (!arrival.any || !hostile || mutator_.pick(10) != 0) return arrival;
    const std::vector<std::uint8_t>& bytes = mutator_.changed({buffer.data, arrival.size});
    arrival.size = std::min(bytes.size(), buffer.size);
    std::memcpy(buffer.data, bytes.data(), arrival.size);
    return arrival;
  }
  double now() noexcept override { return link_.now(); }
  void wait(double seconds) noexcept override { link_.wait(seconds); }
  std::uint32_t address_word() const noexcept override { return link_.address_word(); }

  bool hostile = false;

 private:
  DatagramLink& link_;
  Mutator mutator_{17};
};

TEST(MutatedDatagrams, NeverMakeASessionExceedItsCurrents) {
  for (const CycleProtocol protocol : {CycleProtocol::kSequential, CycleProtocol::kBroadcast}) {
    BoardEmulator emulator({Rig::setup(6), Rig::setup(7)}, 3);
    EmulatedLink direct(emulator);
    HostileLink link(direct);
    BoardSession session(link, Rig::options(protocol));
    session.start();
    long runs = 0, faults = 0;
    for (long k = 0; k < 60000; ++k) {
      link.hostile = k % 2000 > 400;  // at times the link is good, and power comes up again
      link.wait(Rig::kCycle);
      session.update();
      for (int b = 0; b < 2; ++b) {
        for (int c = 0; c < kChannels; ++c) session.set_command(b, c, 1e6);
      }
      session.commit();
      const bool drives = session.state() == PowerState::kOn;
      runs += drives ? 1 : 0;
      faults += session.state() == PowerState::kFault ? 1 : 0;
      for (int b = 0; b < 2; ++b) {
        for (int c = 0; c < kChannels; ++c) {
          ASSERT_LE(std::abs(emulator.board(b).dac(c) - kZeroCurrent), Rig::kLargest) << k;
          if (session.state() == PowerState::kOff) {
            ASSERT_EQ(emulator.board(b).drive(c).bits, 0.0) << k;
          }
        }
      }
      if (session.bus().state() == BusState::kRefused) session.start();
      if (session.state() == PowerState::kFault) session.acknowledge();
      if (session.state() == PowerState::kOff && !link.hostile) session.power_on();
    }
    EXPECT_GT(runs, 1000);
    EXPECT_GT(faults, 10);
  }
}

}  // namespace
}  // namespace veridyn::dvrk
