#include <gtest/gtest.h>

#include "dvrk/bad_link.hpp"
#include "dvrk/boards/board_session.hpp"
#include "dvrk/rig.hpp"
#include "veridyn/math/require.hpp"

// Behaviour of the laboratory's programs and firmware that the specification does not cover, and causes
// that name their place.

namespace veridyn::dvrk {
namespace {

// Register 13: bit 0 enabled, bits 2:1 the result of the last command, bits 31:24 the family. The
// chip holds 2048 bytes, read from the byte on that a command names.
TEST(Dallas, TheInterfaceIsEnabledAndACommandSucceeds) {
  for (const int firmware : {7, 8, 9}) {
    BoardSetup setup = Rig::setup(6, firmware);
    EmulatedBoard without(setup);
    without.write(address::kDallas, 2);
    EXPECT_EQ(without.read(address::kDallas) & 0xFF000007U, 1U);
    for (std::size_t k = 0; k < kDallasBytes; ++k)
      setup.dallas.push_back(static_cast<std::uint8_t>((k * 7) ^ (k >> 8)));
    EmulatedBoard board(setup);
    EXPECT_EQ(board.read(address::kDallas) & 0xFF000007U, 0x0B000001U);
    std::vector<std::uint8_t> read;
    for (std::uint32_t from = 0; from < kDallasBytes; from += 256) {
      board.write(address::kDallas, (from << 16) | 2);
      EXPECT_EQ(board.read(address::kDallas) & 0xFF000007U, 0x0B000003U);
      std::array<std::uint8_t, 256> part{};
      board.read_block(0x6000, QuadletSpan({part.data(), part.size()}));
      read.insert(read.end(), part.begin(), part.end());
    }
    EXPECT_EQ(read, setup.dallas);
    EXPECT_EQ(board.read(0x6000), (setup.dallas[1792] << 24) | (setup.dallas[1793] << 16) |
                                      (setup.dallas[1794] << 8) | setup.dallas[1795]);
  }
}

TEST(IoExpander, ItsBitsShowItsPresenceAndTheMotorSupply) {
  for (const bool has : {true, false}) {
    BoardSetup setup = Rig::setup(6);
    setup.io_expander = has;
    EmulatedBoard board(setup);
    PowerChain chain;
    chain.relays_closed = true;
    EXPECT_EQ(board.read(address::kDigitalIn) >> 28, 0U);
    board.write(address::kWatchdog, 0);
    board.write(address::kStatus, control::kPowerOn);
    board.advance(1, chain);
    board.advance(2000000, chain);
    EXPECT_TRUE(board.status().supply_good());
    EXPECT_EQ(board.read(address::kDigitalIn) >> 28, has ? 1U : 0U);
    EXPECT_EQ((board.status().word >> 12) & 1U, has ? 1U : 0U);
  }
}

// The answer to a packet that was not forwarded does not indicate the state of the FireWire bus.
TEST(Trailer, OfAnUnforwardedPacketIsNotTakenForABusReset) {
  for (const bool local : {true, false}) {
    Rig rig(CycleProtocol::kSequential, {Rig::setup(6, 9), Rig::setup(7, 9)});
    ASSERT_TRUE(rig.bring_up());
    rig.emulator.faults.generation_ahead = 1;
    if (local) rig.emulator.faults.flags = kFlagNoForward;
    rig.cycles(5, 100.0);
    EXPECT_EQ(rig.count(Condition::kGenerationChanged) == 0, local);
    EXPECT_EQ(rig.session.state() == PowerState::kOn, local);
  }
}

// Rev 7 shows commands in registers alone: a board that ignores real-time writes is found there.
TEST(Rev7, ABoardThatIgnoresWritesIsDetected) {
  for (const bool ignores : {true, false}) {
    Rig rig(CycleProtocol::kAutomatic, {Rig::setup(6, 7), Rig::setup(7, 7)});
    ASSERT_TRUE(rig.bring_up());
    for (int k = 0; k < 50; ++k) rig.cycle(100.0 + k);
    rig.emulator.board(1).faults.ignores_writes = ignores;
    int cycles = 0;
    while (cycles < 200 && rig.session.state() == PowerState::kOn) rig.cycle(200.0 + ++cycles % 9);
    if (!ignores) {
      EXPECT_EQ(rig.session.state(), PowerState::kOn) << rig.session.faults().report();
      EXPECT_EQ(rig.count(Condition::kNotEffective), 0);
      continue;
    }
    EXPECT_EQ(rig.session.state(), PowerState::kFault);
    EXPECT_EQ(rig.session.cause(), Condition::kNotEffective);
    EXPECT_EQ(rig.session.cause_text(), "a write had no effect (board 7)");
    EXPECT_LT(cycles, 60);
  }
}

// A relay that opens takes the supply from every board; the board of the relay is named.
TEST(Causes, ARelayThatOpensIsNamedWithItsBoard) {
  for (const int place : {0, 1}) {
    Rig rig;
    ASSERT_TRUE(rig.bring_up());
    rig.emulator.board(place).faults.relay_stuck_open = true;
    rig.cycles(30, 100.0);
    EXPECT_EQ(rig.session.cause(), Condition::kRelayOpen);
    EXPECT_EQ(rig.session.cause_text(),
              "the safety relay is open (board " + std::to_string(6 + place) + ")");
  }
  Rig rig;  // an emergency stop leaves the relays alone
  ASSERT_TRUE(rig.bring_up());
  rig.emulator.chain.emergency_stop = true;
  rig.cycles(30, 100.0);
  EXPECT_EQ(rig.session.cause(), Condition::kNoSupply);
}

TEST(Causes, AWrongBoardAndABusResetAreDistinguished) {
  Rig rig;
  ASSERT_TRUE(rig.bring_up());
  rig.emulator.board(1).faults.wrong_id = 3;
  rig.cycles(5, 100.0);
  EXPECT_EQ(rig.session.cause(), Condition::kWrongBoard);
  Rig other;
  ASSERT_TRUE(other.bring_up());
  other.emulator.bus_reset();
  other.cycles(5, 100.0);
  EXPECT_EQ(other.session.cause(), Condition::kGenerationChanged);
}

// Without FireWire a node is its board's id, nothing is forwarded, and "all" is a group (section
// 8.5): a session comes up, drives both boards and goes down.
TEST(EthernetOnly, ASessionWithoutFirewireDrivesFpgaV3Boards) {
  for (const CycleProtocol protocol : {CycleProtocol::kAutomatic, CycleProtocol::kSequential}) {
    Rig rig(protocol, {Rig::setup(6, 9), Rig::setup(7, 9)});
    rig.emulator.without_firewire();
    ASSERT_TRUE(rig.bring_up()) << rig.session.faults().report();
    EXPECT_TRUE(rig.session.bus().ethernet_only());
    rig.cycles(50, 321.0);
    EXPECT_EQ(rig.emulator.board(0).drive(2).bits, 321.0);
    EXPECT_EQ(rig.emulator.board(1).drive(3).bits, 321.0);
    EXPECT_EQ(rig.session.state(), PowerState::kOn) << rig.session.faults().report();
    rig.emulator.bus_reset();  // on an unused FireWire bus
    rig.cycles(5, 321.0);
    EXPECT_EQ(rig.session.state(), PowerState::kOn) << rig.session.faults().report();
    EXPECT_EQ(rig.session.shutdown(), OffState::kConfirmed);
    EXPECT_FALSE(rig.any_amp_on());
  }
  SessionOptions forced = Rig::options();
  forced.bus.firewire = true;
  Rig bridge(forced, {Rig::setup(6, 9), Rig::setup(7, 9)});
  bridge.emulator.without_firewire();
  EXPECT_THROW(bridge.session.start(), InvalidInput);  // no board is on FireWire
  Rig broadcast(CycleProtocol::kBroadcast, {Rig::setup(6, 9), Rig::setup(7, 9)});
  broadcast.emulator.without_firewire();
  EXPECT_THROW(broadcast.session.start(), InvalidInput);
}

// The laboratory's query, byte for byte as section 19.10 captured it; the blocks come unasked.
TEST(EthernetOnly, ABroadcastQueryIsAnsweredWithTheBlocksOfAllBoards) {
  BoardEmulator emulator({Rig::setup(6, 9), Rig::setup(7, 9)}, 0);
  emulator.without_firewire();
  const std::array<std::uint8_t, 22> query{0x01, 0x03, 0xff, 0xff, 0xbc, 0x00, 0xff, 0xd0, 0x00, 0x00, 0x00,
                                           0x00, 0x18, 0x00, 0x00, 0x03, 0x00, 0xc0, 0x53, 0x78, 0x75, 0xc8};
  std::array<std::uint8_t, kDatagramBuffer> out{};
  const Answer answer = emulator.handle({query.data(), query.size()}, 1000, {out.data(), out.size()});
  ASSERT_EQ(answer.size, 32U + 268U);
  EXPECT_EQ(load_quadlet(out.data()), 0xffd0bc70U);
  EXPECT_EQ(load_quadlet(out.data() + 4), 0xffc60000U);
  EXPECT_EQ(load_quadlet(out.data() + 12), 0x010c0000U);
  EXPECT_EQ(load_quadlet(out.data() + 20) >> 16, 0x2103U);           // 33 quadlets, sequence 3
  EXPECT_EQ((load_quadlet(out.data() + 20 + 4 * 35) >> 24) & 0xF, 7U);  // status of board 7
  EXPECT_EQ(out[answer.size - 8], 0x10);
}

}  // namespace
}  // namespace veridyn::dvrk
