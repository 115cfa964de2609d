#include "dvrk/boards/board_session.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <set>
#include <string>

#include "dvrk/rig.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

TEST(BoardSession, PowersUpInOrderAndDrivesTheCommandedCurrents) {
  Rig rig;
  rig.session.start();
  EXPECT_STREQ(rig.session.power_on(), "the last read was not valid");
  rig.cycles(5, 500.0);
  EXPECT_EQ(rig.session.state(), PowerState::kOff);
  EXPECT_FALSE(rig.currents_flow());
  ASSERT_EQ(rig.session.power_on(), nullptr);
  std::vector<PowerState> seen;
  int on_cycles = 0;
  for (int k = 0; k < 300; ++k) {
    rig.cycle(500.0);
    if (seen.empty() || seen.back() != rig.session.state()) seen.push_back(rig.session.state());
    EXPECT_EQ(rig.currents_flow(),
              rig.session.state() == PowerState::kOn && seen.size() == 4 && ++on_cycles > 0);
  }
  EXPECT_EQ(seen, (std::vector<PowerState>{PowerState::kRelay, PowerState::kPower,
                                           PowerState::kAmps, PowerState::kOn}));
  for (int b = 0; b < 2; ++b) {
    for (int c = 0; c < kChannels; ++c) EXPECT_EQ(rig.emulator.board(b).drive(c).bits, 500.0);
  }
  EXPECT_EQ(rig.session.faults().report(), "");
}

TEST(BoardSession, CommandsAreLimitedAndNonFiniteOnesAreZero) {
  Rig rig;
  ASSERT_TRUE(rig.bring_up());
  rig.cycle(1e9);
  EXPECT_EQ(rig.emulator.board(0).drive(0).bits, Rig::kLargest);
  rig.cycle(-1e9);
  EXPECT_EQ(rig.emulator.board(1).drive(2).bits, -Rig::kLargest);
  rig.cycle(std::nan(""));
  EXPECT_FALSE(rig.currents_flow());
  rig.session.update();  // no board answers
  rig.session.commit();
  EXPECT_FALSE(rig.currents_flow());
}

TEST(BoardSession, PowerDownDisablesAmplifiersFirstAndIsConfirmed) {
  Rig rig;
  ASSERT_TRUE(rig.bring_up());
  rig.cycles(3, 700.0);
  rig.session.power_off();
  rig.cycle(700.0);
  EXPECT_FALSE(rig.any_amp_on());
  EXPECT_TRUE(rig.emulator.board(0).status().power_requested());
  rig.cycles(5);
  EXPECT_FALSE(rig.emulator.board(0).status().power_requested());
  ASSERT_TRUE(rig.power_up());
  EXPECT_EQ(rig.session.shutdown(), OffState::kConfirmed);
  EXPECT_FALSE(rig.any_amp_on());
}

// Every exit leaves no current: the destructor, an exception through it, a client that dies.
TEST(BoardSession, DestructorExceptionAndClientDeathLeaveNoCurrent) {
  for (const bool by_exception : {false, true}) {
    BoardEmulator emulator({Rig::setup(6), Rig::setup(7)}, 3);
    EmulatedLink link(emulator);
    try {
      BoardSession session(link, Rig::options());
      session.start();
      const auto run = [&](int cycles) {
        for (int k = 0; k < cycles; ++k) {
          link.wait(Rig::kCycle);
          session.update();
          session.set_command(0, 0, 33000.0);
          session.commit();
        }
      };
      run(5);
      ASSERT_EQ(session.power_on(), nullptr);
      run(400);
      ASSERT_NE(emulator.board(0).drive(0).bits, 0.0);
      if (by_exception) throw std::runtime_error("a controller failed");
    } catch (const std::runtime_error&) {
    }
    for (int b = 0; b < 2; ++b) {
      for (int c = 0; c < kChannels; ++c) EXPECT_FALSE(emulator.board(b).amp_on(c));
      EXPECT_FALSE(emulator.board(b).status().power_requested());
      EXPECT_EQ(emulator.board(b).dac(0), kZeroCurrent);
    }
  }
  Rig dead;
  ASSERT_TRUE(dead.bring_up());
  dead.cycles(3, 900.0);
  EXPECT_TRUE(dead.currents_flow());
  dead.link.wait(0.031);  // no more writes: the watchdog
  EXPECT_FALSE(dead.currents_flow());
}

TEST(BoardSession, ABusResetDoesNotPreventPowerOff) {
  Rig rig;
  ASSERT_TRUE(rig.bring_up());
  rig.cycles(3, 900.0);
  rig.emulator.bus_reset();  // node-addressed writes vanish now (section 6)
  rig.session.shutdown();
  EXPECT_FALSE(rig.any_amp_on());
  EXPECT_FALSE(rig.emulator.board(0).status().power_requested());
}

TEST(BoardSession, ABoardThatIgnoresEverythingIsLeftToItsWatchdog) {
  Rig rig;
  ASSERT_TRUE(rig.bring_up());
  rig.cycles(3, 900.0);
  rig.emulator.board(1).faults.ignores_writes = true;
  for (int k = 0; k < 10; ++k) rig.cycle(900.0 + k);
  EXPECT_EQ(rig.session.state(), PowerState::kFault);
  EXPECT_EQ(rig.session.cause(), Condition::kNotEffective);
  rig.cycles(30);  // through the register
  EXPECT_FALSE(rig.any_amp_on());
}

// Ignored writes still reset its watchdog, and so do the queries of a broadcast read: all must end.
TEST(BoardSession, ABoardThatIgnoresRegistersTooIsLeftToItsWatchdog) {
  for (const CycleProtocol protocol : {CycleProtocol::kSequential, CycleProtocol::kBroadcastWrite, CycleProtocol::kBroadcast}) {
    SCOPED_TRACE(static_cast<int>(protocol));
    Rig rig(protocol);
    ASSERT_TRUE(rig.bring_up());
    rig.cycles(3, 900.0);
    rig.emulator.board(1).faults.ignores_writes = rig.emulator.board(1).faults.ignores_registers = true;
    for (int k = 0; k < 10; ++k) rig.cycle(900.0 + k);
    EXPECT_EQ(rig.session.state(), PowerState::kFault);
    rig.cycles(120);  // 80 ms
    EXPECT_FALSE(rig.any_amp_on());
    EXPECT_TRUE(rig.emulator.board(1).watchdog_tripped());
  }
}

// Its ignoring of writes is invisible: without replies, or while a scan looks for boards that do not come back.
TEST(BoardSession, AnUnresponsiveBoardIsLeftToItsWatchdog) {
  for (const CycleProtocol protocol : {CycleProtocol::kSequential, CycleProtocol::kBroadcastWrite, CycleProtocol::kBroadcast}) {
    for (const bool reset : {false, true}) {
      SCOPED_TRACE(testing::Message() << static_cast<int>(protocol) << (reset ? " after a reset" : ""));
      Rig rig(protocol);
      ASSERT_TRUE(rig.bring_up());
      rig.cycles(3, 900.0);
      ASSERT_TRUE(rig.currents_flow());
      rig.emulator.board(1).faults.ignores_writes = rig.emulator.board(1).faults.ignores_registers = true;
      if (reset) {
        rig.emulator.bus_reset(0.0, {1, 0});
        rig.emulator.board(1).faults.wrong_id = 9;  // board 7 is not found again
      } else {
        rig.emulator.faults.reply = ReplyFault::kDrop;
        rig.emulator.faults.replies = -1;
      }
      const double start = rig.link.now();
      while (rig.link.now() - start < 0.3) rig.cycle(900.0);
      EXPECT_EQ(rig.session.state(), PowerState::kFault);
      EXPECT_FALSE(rig.any_amp_on());
      EXPECT_TRUE(rig.emulator.board(1).watchdog_tripped());
      EXPECT_EQ(rig.session.bus().state() == BusState::kScanning, reset);
      EXPECT_FALSE(rig.emulator.board(0).status().power_requested());  // it obeyed before the silence
    }
  }
}

// Conditions that would end a run at once prevent power-up.
TEST(BoardSession, PowerIsRefusedWithItsReason) {
  struct Trouble {
    const char* words;
    std::function<void(Rig&)> make;
  };
  const Trouble troubles[] = {
      {"the motor supply has a fault", [](Rig& rig) { rig.emulator.board(1).faults.supply_fault = true; }},
      {"the encoders have no supply", [](Rig& rig) { rig.emulator.board(0).faults.encoder_supply = true; }},
      {"a board is too warm", [](Rig& rig) { rig.emulator.board(1).temperatures = 0x327A; }},  // 25 and 61 degC
      {"a board is too warm", [](Rig& rig) { rig.emulator.board(0).temperatures = 0x7A32; }},
      {"an encoder reports an error", [](Rig& rig) { rig.emulator.board(1).encoder(3).broken_lines = true; }},
      {"an encoder has run over", [](Rig& rig) { rig.emulator.board(0).encoder(2).overflow_latched = true; }},
      {"a board was rebooted: start() again",
       [](Rig& rig) {
         rig.emulator.board(1).reboot(static_cast<Ticks>(rig.link.now() * kTicksPerSecond));
         rig.cycles(500);
       }},
      {"the boards are not known",
       [](Rig& rig) {
         rig.emulator.board(1).faults.wrong_id = 9;
         rig.emulator.bus_reset();
       }},
      {"the last read was not valid",
       [](Rig& rig) {
         rig.emulator.faults.reply = ReplyFault::kDrop;
         rig.emulator.faults.replies = -1;
       }},
  };
  for (const Trouble& trouble : troubles) {
    Rig rig;
    rig.session.start();
    rig.cycles(5);
    trouble.make(rig);
    rig.cycles(5);
    EXPECT_STREQ(rig.session.power_on(), trouble.words);
    rig.cycles(100, 900.0);
    EXPECT_EQ(rig.session.state(), PowerState::kOff) << trouble.words;
    EXPECT_FALSE(rig.emulator.board(0).status().power_requested() || rig.any_amp_on()) << trouble.words;
  }
  Rig rig;
  ASSERT_TRUE(rig.bring_up());
  EXPECT_STREQ(rig.session.power_on(), "power is on, or on the way");
  rig.emulator.chain.emergency_stop = true;
  rig.cycles(3);
  EXPECT_STREQ(rig.session.power_on(), "a fault was not acknowledged");
  rig.emulator.chain.emergency_stop = false;
  rig.cycles(3);
  EXPECT_TRUE(rig.session.acknowledge());
  EXPECT_TRUE(rig.session.acknowledge());  // there is nothing left to acknowledge
  rig.cycles(3);
  EXPECT_TRUE(rig.power_up());
}

// Its encoders have lost their loaded counts. Soon after the restart no real-time word shows it.
TEST(BoardSession, ARestartedBoardIsDetectedBeforeAmplifiersAreEnabled) {
  for (int b = 0; b < 2; ++b) {
    Rig rig;
    rig.session.start();
    rig.cycles(5);
    rig.emulator.board(b).reboot(static_cast<Ticks>(rig.link.now() * kTicksPerSecond));
    rig.cycles(2);
    ASSERT_EQ(rig.session.power_on(), nullptr);
    for (int k = 0; k < 300; ++k) {
      rig.cycle(900.0);
      ASSERT_FALSE(rig.any_amp_on()) << k;
    }
    EXPECT_EQ(rig.session.state(), PowerState::kFault);
    EXPECT_EQ(rig.session.cause(), Condition::kRebooted);
    EXPECT_FALSE(rig.session.acknowledge());
    rig.session.start();
    rig.cycles(3);
    EXPECT_TRUE(rig.power_up());
  }
}

// A relay that is not even asked to close, since its board ignores blocks, and a supply that does not come.
TEST(BoardSession, PowerUpTimesOut) {
  SessionOptions how = Rig::options();
  how.supply_timeout = 0.5;
  for (const bool supply : {false, true}) {
    Rig rig(how);
    rig.session.start();
    rig.cycles(5);
    if (supply)
      rig.emulator.chain.supply_on = false;
    else
      rig.emulator.board(1).faults.ignores_writes = true;
    ASSERT_EQ(rig.session.power_on(), nullptr);
    const double start = rig.link.now(), most = supply ? how.supply_timeout : how.relay_timeout;
    while (rig.session.state() != PowerState::kFault && rig.link.now() - start < 2.0) rig.cycle(900.0);
    EXPECT_EQ(rig.session.cause(), supply ? Condition::kNoSupply : Condition::kRelayOpen);
    EXPECT_NEAR(rig.link.now() - start, most, 0.05);
    EXPECT_EQ(rig.count(rig.session.cause()), 1);
    rig.cycles(3);
    for (int b = 0; b < 2; ++b) EXPECT_FALSE(rig.emulator.board(b).status().power_requested()) << b;
    EXPECT_FALSE(rig.any_amp_on());
  }
}

TEST(BoardSession, EveryStateHasADescriptionOfItsOwn) {
  std::set<std::string> words;
  for (const PowerState state : {PowerState::kOff, PowerState::kRelay, PowerState::kPower, PowerState::kAmps, PowerState::kOn, PowerState::kFault})
    EXPECT_TRUE(words.insert(describe(state)).second) << describe(state);
  EXPECT_EQ(words.count(""), 0U);
}

TEST(BoardSession, EncodersArePreloadedOnlyWhilePowerIsOff) {
  Rig rig;
  rig.session.start();
  rig.cycles(3);
  EXPECT_TRUE(rig.session.needs_preload(1, 2));
  EXPECT_TRUE(rig.session.preload(1, 2, -12345));
  EXPECT_FALSE(rig.session.needs_preload(1, 2));
  rig.cycle();
  EXPECT_EQ(encoder_counts(rig.session.bus().feedback(1).channel[2].encoder.position), -12345);
  rig.emulator.board(1).encoder(3).overflow_latched = true;
  EXPECT_FALSE(rig.session.preload(1, 3, 0));
  EXPECT_STREQ(rig.session.power_on(), nullptr);  // not read since
  rig.session.power_off();
  rig.cycle();
  EXPECT_STREQ(rig.session.power_on(), "an encoder has run over");
  rig.emulator.board(1).encoder(3).overflow_latched = false;
  rig.cycle();
  ASSERT_TRUE(rig.power_up());
  EXPECT_FALSE(rig.session.preload(1, 2, 0));
}

TEST(BoardSession, BadOptionsAreRefused) {
  BoardEmulator emulator({Rig::setup(6), Rig::setup(7)}, 3);
  EmulatedLink link(emulator);
  SessionOptions options = Rig::options();
  for (const auto seconds : {&SessionOptions::watchdog, &SessionOptions::relay_timeout, &SessionOptions::supply_timeout,
                             &SessionOptions::off_timeout}) {
    for (const double none : {0.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
      options = Rig::options();
      options.*seconds = none;
      EXPECT_THROW(BoardSession(link, options), InvalidInput) << none;
    }
  }
  options = Rig::options();
  options.channels[1][2].max_current = 0.0;
  EXPECT_THROW(BoardSession(link, options), InvalidInput);
}

}  // namespace
}  // namespace veridyn::dvrk
