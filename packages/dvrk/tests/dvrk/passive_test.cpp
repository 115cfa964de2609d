#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "dvrk/arm_bench.hpp"
#include "dvrk/bad_link.hpp"
#include "dvrk/planar_arm.hpp"
#include "dvrk/rig.hpp"
#include "dvrk/udp_proxy.hpp"
#include "dvrk/vectors.hpp"
#include "dvrk/run/arm_run.hpp"
#include "emulator/board_server.hpp"
#include "dvrk/protocol/udp_link.hpp"
#include "veridyn/math/require.hpp"

// A passive reader sends no write: neither at the start, nor in the loop, nor at the end.

namespace veridyn::dvrk {
namespace {

ArmSessionOptions listening(Access access, CycleProtocol protocol = CycleProtocol::kAutomatic) {
  ArmSessionOptions options;
  options.access = access;
  options.protocol = protocol;
  options.rate = 0.0;
  return options;
}

class Listeners : public testing::TestWithParam<Access> {};
INSTANTIATE_TEST_SUITE_P(Both, Listeners,
                         testing::Values(Access::kListen, Access::kListenByRegister));

TEST_P(Listeners, ReadTheArmWithoutSendingAnyWrite) {
  PlanarArm arm;
  BadLink link(arm.emulator);
  std::atomic<bool> stop{false};
  {
    ArmSession session(link, planar_config(), listening(GetParam()));
    int seen = 0;
    watch(session, link, 0.5, 100.0, stop, [&](double) {
      ++seen;
      // The encoders were not loaded: they count from the position at power-up. The pots show the position.
      EXPECT_NEAR(session.state().pot_q[0], 0.4, 1e-3);
      EXPECT_EQ(session.board_of(0).status.board(), 6);
      EXPECT_TRUE(session.needs_homing());
    });
    EXPECT_GT(seen, 20);
    EXPECT_NE(session.power_on(), nullptr);
    EXPECT_FALSE(session.home().done);
    EXPECT_EQ(session.boards().shutdown(), OffState::kNotAsked);
  }
  EXPECT_EQ(link.writes, 0);
  EXPECT_EQ(arm.emulator.counters().writes, 0);
  // The write counter of this test works.
  ArmSession active(link, planar_config());
  active.start();
  EXPECT_GT(link.writes, 3);
}

// Homing beside a program that drives is refused before anything is written.
TEST(Homing, IsRefusedWithoutAWriteWhileTheMotorsHavePower) {
  PlanarArm arm;
  BadLink link(arm.emulator);
  EXPECT_NO_THROW(require_no_power(link, planar_config(), {}));
  EXPECT_EQ(link.writes, 0);
  ArmSession driver(arm.link, planar_config());
  driver.start();
  driver.update();
  driver.commit();
  ASSERT_EQ(driver.power_on(), nullptr);
  for (int k = 0; k < 200; ++k) {
    driver.update();
    driver.commit();
    arm.link.wait(kCycle);
  }
  ASSERT_TRUE(arm.emulator.board(0).status().power_requested());
  EXPECT_THROW(require_no_power(link, planar_config(), {}), InvalidInput);
  EXPECT_EQ(link.writes, 0);
}

TEST_P(Listeners, ReadTheRealTimeBlock) {
  SessionOptions how = Rig::options();
  how.watchdog = 0.34;  // longer than the other one takes to find the boards
  Rig rig(how);
  ASSERT_TRUE(rig.bring_up());
  rig.cycles(10, 777.0);
  SessionOptions options = Rig::options();
  options.bus.access = GetParam();
  options.bus.cycle_time = 0.0;
  BoardSession other(rig.link, options);
  other.start();
  ASSERT_TRUE(other.update());
  rig.cycle(777.0);
  for (int b = 0; b < 2; ++b) {
    const BoardFeedback& ours = rig.session.bus().feedback(b);
    const BoardFeedback& theirs = other.bus().feedback(b);
    EXPECT_EQ(ours.status.word, theirs.status.word);
    EXPECT_EQ(ours.digital.word, theirs.digital.word);
    EXPECT_EQ(ours.temperature.word, theirs.temperature.word);
    for (size_t c = 0; c < kChannels; ++c) {
      EXPECT_EQ(ours.channel[c].current, theirs.channel[c].current);
      EXPECT_EQ(ours.channel[c].pot, theirs.channel[c].pot);
      EXPECT_EQ(ours.channel[c].motor.word, theirs.channel[c].motor.word);
      EXPECT_EQ(ours.channel[c].encoder.position, theirs.channel[c].encoder.position);
      EXPECT_EQ(ours.channel[c].encoder.period, theirs.channel[c].encoder.period);
      EXPECT_EQ(ours.channel[c].encoder.quarter5, theirs.channel[c].encoder.quarter5);
    }
  }
  EXPECT_EQ(rig.session.state(), PowerState::kOn);
}

// Single registers leave the clock of the other client alone; a block restarts it (section 9).
TEST(Listening, ByRegisterDoesNotResetTimestamps) {
  for (const Access access : {Access::kListenByRegister, Access::kListen}) {
    Rig rig;
    ASSERT_TRUE(rig.bring_up());
    SessionOptions options = Rig::options();
    options.bus.access = access;
    options.bus.cycle_time = 0.0;
    BoardSession other(rig.link, options);
    other.start();
    rig.cycles(2);
    const double before = rig.link.now();
    rig.link.wait(0.001);
    ASSERT_TRUE(other.update());
    rig.link.wait(0.001);
    ASSERT_TRUE(rig.session.update());
    const double told = rig.session.bus().feedback(1).seconds();
    if (access == Access::kListen) {
      EXPECT_LT(told, 0.0016);
    } else {
      EXPECT_GT(told, rig.link.now() - before);  // since the last read of the session
    }
  }
}

// A second host with the packets of an independent implementation: those of
// section 19 drive both boards while we look. Its amplifiers stay on.
TEST(Listening, ListeningLeavesTheAmplifiersOfAnotherHostOn) {
  BoardEmulator emulator({Rig::setup(6), Rig::setup(7)}, 3);
  BadLink host(emulator), ours(emulator);
  const auto send = [&](const char* section, const char* name) {
    const std::vector<std::uint8_t> bytes = bytes_of(vector_named(section, name).hex);
    host.send({bytes.data(), bytes.size()}, Destination::kBoard);
  };
  const auto to_both = [&](std::uint32_t word) {
    for (int b = 0; b < 2; ++b) emulator.board(b).write(address::kStatus, word);
  };
  host.wait(0.001);
  to_both(control::kRelayClose);
  to_both(control::kPowerOn);
  host.wait(0.1);
  to_both(control::kAmpsOn);
  host.wait(0.05);
  SessionOptions options = Rig::options();
  options.bus.access = Access::kListenByRegister;
  options.bus.cycle_time = 0.0;
  BoardSession session(ours, options);
  session.start();
  // The clock of `ours` has not moved with that of `host`: catch up.
  to_both(control::kPowerOn);
  to_both(control::kAmpsOn);
  const long writes = emulator.counters().writes;
  long of_host = 0;
  for (int k = 0; k < 200; ++k) {
    send("19.7", "3 write all");
    ++of_host;
    ASSERT_TRUE(session.update()) << session.faults().report();
    session.commit();
    host.wait(std::max(1e-4, ours.now() - host.now()));
  }
  EXPECT_EQ(session.shutdown(), OffState::kNotAsked);
  EXPECT_EQ(ours.writes, 0);
  EXPECT_EQ(emulator.counters().writes - writes, of_host);
  for (int b = 0; b < 2; ++b) {
    EXPECT_TRUE(emulator.board(b).status().power_requested());
    for (int c = 0; c < kChannels; ++c) {
      EXPECT_TRUE(emulator.board(b).amp_on(c));
      EXPECT_EQ(emulator.board(b).dac(c), 0x8010 + 0x10 * c);
    }
  }
}

// Over real sockets, during a run. On a busy machine the clock may end the run, but never the
// passive reader.
TEST(Listening, AListenerReadsDuringARunOverUdp) {
  PlanarArm arm;
  BoardServer server(arm.emulator, 0);
  std::atomic<bool> stop_server{false}, stop{false};
  std::thread boards([&] { server.run(stop_server); });
  RunResult run;
  std::atomic<bool> running{true};
  std::thread driver([&] {
    UdpLink link("127.0.0.1", server.port());
    ArmSessionOptions options;
    options.rate = 500.0;
    options.watchdog = 0.3;
    ArmSession session(link, planar_config(), options);
    RunOptions how;
    how.rate = 500.0;
    how.approach_speed = 2.0;
    how.approach_time = 0.5;
    run = run_motion(session, link, swinging(1.5, {0.1, 0.1}, 0.2),
                     sensible_gains(read_model("planar-2r")), how, stop);
    running = false;
  });
  UdpProxy proxy(server.port());
  int seen = 0, powered = 0;
  while (running) {
    UdpLink link("127.0.0.1", proxy.port());
    ArmSession session(link, planar_config(), listening(Access::kListenByRegister));
    try {
      watch(session, link, 1.0, 25.0, stop, [&](double) {
        ++seen;
        powered += session.board_of(0).status.power_requested() ? 1 : 0;
      });
    } catch (const InvalidInput&) {  // a busy machine: no answer within 20 ms
    }
  }
  driver.join();
  stop_server = true;
  boards.join();
  EXPECT_EQ(proxy.writes(), 0);
  EXPECT_GT(proxy.reads(), 0);
  EXPECT_GT(seen, 0);
  EXPECT_TRUE(powered > 0 || run.why.find("too busy") != std::string::npos) << run.why;
  const bool by_the_clock = run.why.find("late") != std::string::npos ||
                            run.why.find(describe(Condition::kWatchdog)) == 0 ||
                            run.why.find(describe(Condition::kNoReply)) == 0 ||
                            run.timing.longest_gap.seconds > 0.02 || run.timing.measured_rate() < 450.0;  // no loop of 500 Hz
  EXPECT_TRUE(run.complete || by_the_clock) << run.why;
  EXPECT_EQ(run.power, OffState::kConfirmed);
  EXPECT_FALSE(arm.emulator.board(0).status().power_requested());
}

}  // namespace
}  // namespace veridyn::dvrk
