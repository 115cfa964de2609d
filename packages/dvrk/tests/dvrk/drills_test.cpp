#include <gtest/gtest.h>

#include "dvrk/bad_link.hpp"
#include "dvrk/rig.hpp"

// Bad networks and boards that die, with a clock that the test moves. Whatever happens, three
// things must hold: no current without a session that drives, none longer than the watchdog after
// it stopped, and "power is off" is reported only if it is true.

namespace veridyn::dvrk {
namespace {

constexpr double kPeriod = 1.0 / 1500.0;

class Drill {
 public:
  explicit Drill(CycleProtocol protocol = CycleProtocol::kAutomatic, std::uint64_t seed = 1)
      : emulator({Rig::setup(6), Rig::setup(7)}, 3),
        link(emulator, seed),
        session(link, options_of(protocol)) {}

  static SessionOptions options_of(CycleProtocol protocol) { return Rig::options(protocol); }

  void cycle(double bits) {
    const double began = link.now();
    session.update();
    for (int b = 0; b < 2; ++b) {
      for (int c = 0; c < kChannels; ++c) session.set_command(b, c, kZeroCurrent + bits);
    }
    session.commit();
    const double left = kPeriod - (link.now() - began);
    if (left > 0.0) link.wait(left);
  }
  bool bring_up() {
    session.start();
    for (int k = 0; k < 5; ++k) cycle(0.0);
    if (session.power_on() != nullptr) return false;
    for (int k = 0; k < 900 && session.state() != PowerState::kOn; ++k) cycle(0.0);
    return session.state() == PowerState::kOn;
  }
  bool currents_flow() {
    for (int b = 0; b < 2; ++b) {
      for (int c = 0; c < kChannels; ++c) {
        if (emulator.board(b).drive(c).bits != 0.0) return true;
      }
    }
    return false;
  }
  // The true state, which only the boards know.
  bool really_off() {
    for (int b = 0; b < 2; ++b) {
      if (emulator.board(b).status().power_requested()) return false;
      for (int c = 0; c < kChannels; ++c) {
        if (emulator.board(b).amp_on(c)) return false;
      }
    }
    return true;
  }

  BoardEmulator emulator;
  BadLink link;
  BoardSession session;
};

// Good enough for currents, or not; or it depends on how the boards are read.
enum class Worth { kGood, kBad, kDepends };

struct Network {
  const char* name;
  Mischief up, down;
  Worth is;
};

std::vector<Network> networks() {
  const auto with = [](auto change) {
    Mischief m;
    change(m);
    return m;
  };
  const Mischief none;
  const Mischief little = with([](Mischief& m) { m.lose = 0.01; });
  const Mischief lossy = with([](Mischief& m) { m.lose = 0.05; });
  const Mischief bad = with([](Mischief& m) { m.lose = 0.2; });
  const Mischief twice = with([](Mischief& m) { m.repeat = 0.3; });
  const Mischief mixed = with([](Mischief& m) { m.hold = 0.05; });
  const Mischief noisy = with([](Mischief& m) { m.corrupt = 0.05; });
  const Mischief jitter = with([](Mischief& m) {
    m.delay = 50e-6;
    m.jitter = 50e-6;
  });
  const Mischief late = with([](Mischief& m) { m.delay = 0.015; });
  const Mischief gone = with([](Mischief& m) { m.lose = 1.0; });
  const Mischief deaf = with([](Mischief& m) { m.lose_writes = true; });
  return {{"ALittleLoss", little, little, Worth::kGood},
          {"Loss", lossy, lossy, Worth::kBad},  // within a window of ReplyLoss
          {"MuchLoss", bad, bad, Worth::kBad},
          {"Repeats", twice, twice, Worth::kGood},
          {"Reorders", mixed, mixed, Worth::kDepends},
          {"CorruptsReplies", none, noisy, Worth::kBad},
          {"CorruptsRequests", noisy, none, Worth::kBad},
          {"Jitter", jitter, jitter, Worth::kDepends},
          {"LateReplies", none, late, Worth::kDepends},
          {"NoReplies", none, gone, Worth::kBad},
          {"NoRequests", gone, none, Worth::kBad},
          {"NoWrites", deaf, none, Worth::kBad}};
}

class BadNetwork : public testing::TestWithParam<std::tuple<Network, CycleProtocol>> {};
INSTANTIATE_TEST_SUITE_P(Kinds, BadNetwork,
                         testing::Combine(testing::ValuesIn(networks()),
                                          testing::Values(CycleProtocol::kBroadcastWrite,
                                                          CycleProtocol::kSequential,
                                                          CycleProtocol::kBroadcast)),
                         [](const auto& of) {
                           return std::string(std::get<0>(of.param).name) +
                                  std::to_string(static_cast<int>(std::get<1>(of.param)));
                         });

TEST_P(BadNetwork, LeavesNoCurrentAfterAFaultAndNoFalseReport) {
  const auto& [network, protocol] = GetParam();
  Drill drill(protocol);
  ASSERT_TRUE(drill.bring_up()) << drill.session.faults().report();
  for (int k = 0; k < 20; ++k) drill.cycle(1000.0 + k % 7);
  ASSERT_TRUE(drill.currents_flow());
  drill.link.up = network.up;
  drill.link.down = network.down;
  double off_since = -1.0;
  const int window = static_cast<int>(2 * ReplyLoss::kRequests);
  for (int k = 0; k < window; ++k) {
    drill.cycle(1000.0 + k % 7);
    if (drill.session.state() == PowerState::kOn) {
      off_since = -1.0;
      continue;
    }
    if (off_since < 0.0) off_since = drill.link.now();
    // A fault switches off at once, or the watchdog does; a command that was held may come last.
    if (drill.link.now() - off_since > 0.032 && protocol != CycleProtocol::kBroadcast) {
      ASSERT_FALSE(drill.currents_flow()) << drill.session.faults().report();
    }
    if (drill.link.now() - off_since > 0.2) break;
  }
  if (network.is != Worth::kDepends) {
    EXPECT_EQ(drill.session.state() == PowerState::kOn, network.is == Worth::kGood)
        << drill.session.faults().report();
  }
  const OffState said = drill.session.shutdown();
  if (said == OffState::kConfirmed) {
    EXPECT_TRUE(drill.really_off());
  }
  if (network.up.lose >= 1.0 || network.down.lose >= 1.0 || network.up.lose_writes) {
    EXPECT_NE(said, OffState::kConfirmed);
  }
  drill.link.wait(0.031);
  EXPECT_FALSE(drill.currents_flow()) << describe(said);
  // A network that works again: the same call confirms, and it is true.
  drill.link.up = drill.link.down = Mischief();
  drill.link.wait(0.1);
  EXPECT_EQ(drill.session.shutdown(), OffState::kConfirmed) << drill.session.faults().report();
  EXPECT_TRUE(drill.really_off());
}

TEST(Drills, AClientThatDiesLeavesNoTorqueAfterTheWatchdog) {
  Drill drill;
  ASSERT_TRUE(drill.bring_up());
  for (int k = 0; k < 10; ++k) drill.cycle(1500.0);
  ASSERT_TRUE(drill.currents_flow());
  drill.link.wait(0.029);  // killed: no more datagrams
  EXPECT_TRUE(drill.currents_flow());
  drill.link.wait(0.0021);
  EXPECT_FALSE(drill.currents_flow());
  EXPECT_TRUE(drill.emulator.board(0).watchdog_tripped());
}

TEST(Drills, LostWritesAreNotReportedAsPowerOff) {
  Drill drill;
  ASSERT_TRUE(drill.bring_up());
  for (int k = 0; k < 10; ++k) drill.cycle(1500.0);
  drill.emulator.faults.lose_writes = true;
  for (int k = 0; k < 60; ++k) drill.cycle(1500.0 + k);
  EXPECT_EQ(drill.session.state(), PowerState::kFault);
  EXPECT_EQ(drill.session.shutdown(), OffState::kPowerOn);  // amplifiers by the watchdog
  EXPECT_FALSE(drill.really_off());
  drill.emulator.faults.lose_writes = false;
  EXPECT_EQ(drill.session.shutdown(), OffState::kConfirmed);
  EXPECT_TRUE(drill.really_off());
}

TEST(Drills, PowerOffWithoutRepliesIsReportedAsUnknown) {
  Drill drill;
  ASSERT_TRUE(drill.bring_up());
  drill.link.down.lose = 1.0;
  const double start = drill.link.now();
  EXPECT_EQ(drill.session.shutdown(), OffState::kUnknown);
  EXPECT_LT(drill.link.now() - start, 0.7);  // and it does not try for ever
  EXPECT_TRUE(drill.really_off());           // the writes had arrived, but this could not be confirmed
}

// Nodes get new numbers while the motors run: off is confirmed all the same, after a scan.
TEST(Drills, PowerOffIsConfirmedAfterABusReset) {
  Drill drill;
  ASSERT_TRUE(drill.bring_up());
  drill.emulator.bus_reset(0.01, {1, 0});
  EXPECT_EQ(drill.session.shutdown(), OffState::kConfirmed) << drill.session.faults().report();
  EXPECT_TRUE(drill.really_off());
}

// Enabling one amplifier does not clear the trip of another (section 14.3).
TEST(Drills, EnablingAnAmplifierClearsOnlyItsOwnTrip) {
  EmulatedBoard board(Rig::setup(6));
  PowerChain chain;
  chain.relays_closed = true;
  Ticks now = 0;
  const auto pass = [&](double seconds) {
    for (int k = 0; k < 100; ++k)
      board.advance(now += static_cast<Ticks>(seconds * kTicksPerSecond / 100), chain);
  };
  board.write(address::kWatchdog, 0);
  board.write(address::kStatus, control::kPowerOn);
  pass(0.1);
  board.write(address::kStatus, control::kAmpsOn);
  board.faults.current[1] = board.faults.current[2] = 0x1800;
  pass(0.06);
  EXPECT_TRUE(board.status().current_trip(1) && board.status().current_trip(2));
  board.faults.current = {};
  board.write(address::kStatus, 0x00000202);  // axis 2 on
  EXPECT_FALSE(board.status().current_trip(1));
  EXPECT_TRUE(board.status().current_trip(2));
  board.write(address::kStatus, control::kPowerOn);
  EXPECT_FALSE(board.status().current_trip(2));
}

}  // namespace
}  // namespace veridyn::dvrk
