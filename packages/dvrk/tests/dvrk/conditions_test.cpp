#include <gtest/gtest.h>

#include "dvrk/rig.hpp"

// The error conditions of section 17 that can happen to a running session, each injected while
// currents flow. (10, 11, 12 and 16 are refusals at the start: board_bus_test.cpp.)

namespace veridyn::dvrk {
namespace {

enum class Asked {
  kGoOn,      ///< counted; the session goes on
  kStop,      ///< amplifiers off
  kPowerOff,  ///< amplifiers and power off
};

struct Row {
  const char* name;
  Condition condition;
  CycleProtocol protocol;
  std::function<void(Rig&)> inject;
  Asked asked;
  double grace;  ///< [s] in which the reaction must come; 0: within one cycle
  std::function<void(Rig&)> remove;
  bool restart = false;  ///< start() is needed afterwards
};

void PrintTo(const Row& row, std::ostream* out) {
  *out << row.name;
}

std::function<void(Rig&)> reply(ReplyFault fault, int count) {
  return [=](Rig& rig) {
    rig.emulator.faults.reply = fault;
    rig.emulator.faults.replies = count;
  };
}

void clean(Rig& rig) {
  rig.emulator.faults = EmulatorFaults();
  for (int b = 0; b < 2; ++b) {
    rig.emulator.board(b).faults = BoardFaults();
    rig.emulator.board(b).temperatures = 0x3234;
    rig.emulator.board(b).ethernet = kEthernetHealthy;
    for (int c = 0; c < kChannels; ++c) {
      rig.emulator.board(b).encoder(c).overflow_latched = false;
      rig.emulator.board(b).encoder(c).broken_lines = false;
    }
  }
  rig.emulator.chain.emergency_stop = false;
  rig.emulator.chain.supply_on = true;
  rig.link.cut = false;
}

template <typename Change>
std::function<void(Rig&)> on_board(Change change) {
  return [=](Rig& rig) { change(rig.emulator.board(1)); };
}

const std::vector<Row>& rows() {
  constexpr auto kAuto = CycleProtocol::kAutomatic;
  constexpr auto kQuery = CycleProtocol::kBroadcast;
  static const std::vector<Row> kRows = {
      {"NoReply", Condition::kNoReply, kAuto, reply(ReplyFault::kDrop, 1), Asked::kGoOn, 0, clean},
      {"NoReplies", Condition::kNoReply, kAuto, reply(ReplyFault::kDrop, -1), Asked::kPowerOff,
       0.07, clean},
      {"LateReply", Condition::kWrongHeader, kAuto,
       [](Rig& rig) {  // after its read has given up: the next read finds it
         reply(ReplyFault::kDelay, 1)(rig);
         rig.emulator.faults.delay = 0.01996;
       },
       Asked::kGoOn, 0.0015, clean},
      {"ShortReply", Condition::kWrongSize, kAuto, reply(ReplyFault::kTruncate, 1), Asked::kGoOn, 0,
       clean},
      {"LongReplies", Condition::kWrongSize, kAuto, reply(ReplyFault::kExtend, -1),
       Asked::kPowerOff, 0.0025, clean},
      {"Dropped", Condition::kDropped, kAuto, [](Rig& rig) { rig.emulator.bus_reset(); },
       Asked::kStop, 0, clean},
      {"GenerationChange", Condition::kGenerationChanged, kAuto,
       [](Rig& rig) { rig.emulator.faults.generation_ahead = 1; }, Asked::kStop, 0, clean},
      {"BusReset", Condition::kBusReset, kAuto, [](Rig& rig) { rig.emulator.bus_reset(0.05); },
       Asked::kStop, 0.032, clean},
      {"BusResetBroadcast", Condition::kBusReset, kQuery,
       [](Rig& rig) {
         rig.emulator.bus_reset(0.05, {1, 0});
       },
       Asked::kStop, 0.032, clean},
      {"WrongLabel", Condition::kWrongHeader, kAuto, reply(ReplyFault::kLabel, 1), Asked::kGoOn, 0,
       clean},
      {"WrongTcode", Condition::kWrongHeader, kAuto, reply(ReplyFault::kTcode, 1), Asked::kGoOn, 0,
       clean},
      {"WrongNode", Condition::kWrongHeader, kAuto, reply(ReplyFault::kNode, 1), Asked::kGoOn, 0,
       clean},
      {"WrongLength", Condition::kWrongHeader, kAuto, reply(ReplyFault::kLength, 1), Asked::kGoOn,
       0, clean},
      {"WrongBus", Condition::kWrongHeader, kAuto, reply(ReplyFault::kBus, -1), Asked::kPowerOff,
       0.0025, clean},
      {"StaleReply", Condition::kStaleReply, kAuto,
       [](Rig& rig) {
         static const std::uint8_t kOld[28] = {0xFF, 0xD0};
         rig.link.push({kOld, sizeof kOld});
       },
       Asked::kGoOn, 0, clean},
      {"WrongCrc", Condition::kWrongCrc, kAuto, reply(ReplyFault::kCrc, 1), Asked::kGoOn, 0, clean},
      {"WrongCrcs", Condition::kWrongCrc, kAuto, reply(ReplyFault::kCrc, -1), Asked::kPowerOff,
       0.0025, clean},
      {"WrongBoard", Condition::kWrongBoard, kAuto,
       on_board([](EmulatedBoard& b) { b.faults.wrong_id = 9; }), Asked::kStop, 0, clean},
      {"StaleSequence", Condition::kStaleSequence, kQuery,
       on_board([](EmulatedBoard& b) { b.faults.wrong_sequence = 1; }), Asked::kPowerOff, 0.0025,
       clean},
      {"MissingBoard", Condition::kMissingBoard, kQuery,
       on_board([](EmulatedBoard& b) { b.faults.skips_query = true; }), Asked::kPowerOff, 0.0025,
       clean},
      {"WrongBlockSize", Condition::kWrongBlockSize, kQuery,
       on_board([](EmulatedBoard& b) { b.faults.wrong_block_size = 2; }), Asked::kPowerOff, 0.0025,
       clean},
      {"Watchdog", Condition::kWatchdog, kAuto, [](Rig& rig) { rig.link.wait(0.031); },
       Asked::kStop, 0, clean},
      {"EmergencyStop", Condition::kNoSupply, kAuto,
       [](Rig& rig) { rig.emulator.chain.emergency_stop = true; }, Asked::kStop, 0, clean},
      {"SupplyOff", Condition::kNoSupply, kQuery,
       [](Rig& rig) { rig.emulator.chain.supply_on = false; }, Asked::kStop, 0, clean},
      {"SupplyFault", Condition::kSupplyFault, kAuto,
       on_board([](EmulatedBoard& b) { b.faults.supply_fault = true; }), Asked::kPowerOff, 0,
       clean},
      {"RelayOpen", Condition::kRelayOpen, kAuto,
       on_board([](EmulatedBoard& b) { b.faults.relay_stuck_open = true; }), Asked::kStop, 0,
       clean},
      {"AmpFault", Condition::kAmpOff, kAuto,
       on_board([](EmulatedBoard& b) { b.faults.amp[2] = true; }), Asked::kStop, 0, clean},
      {"CurrentTrip", Condition::kCurrentTrip, kAuto,
       on_board([](EmulatedBoard& b) { b.faults.current[1] = 0x1800; }), Asked::kStop, 0.052,
       clean},
      {"CurrentOutOfBounds", Condition::kOutOfBounds, kAuto,
       on_board([](EmulatedBoard& b) { b.faults.current[0] = 500; }), Asked::kPowerOff, 0.02,
       clean},
      {"CurrentStuck", Condition::kOutOfBounds, kAuto,
       [](Rig& rig) {
         rig.cycles(2, 0.0);  // the amplifier carries the first command out in the second
         rig.emulator.board(1).faults.stuck[2] = true;
       },
       Asked::kPowerOff, 0.02, clean},
      {"Hot", Condition::kTemperature, kAuto,
       on_board([](EmulatedBoard& b) { b.temperatures = 0x3284; }), Asked::kPowerOff, 0, clean},
      {"Warm", Condition::kTemperature, kAuto,
       on_board([](EmulatedBoard& b) { b.temperatures = 0x7A32; }), Asked::kGoOn, 0, clean},
      {"NoTemperature", Condition::kTemperature, kAuto,
       on_board([](EmulatedBoard& b) { b.temperatures = 0xFF32; }), Asked::kGoOn, 0, clean},
      {"EncoderOverflow", Condition::kEncoder, kAuto,
       on_board([](EmulatedBoard& b) { b.encoder(0).overflow_latched = true; }), Asked::kPowerOff,
       0, clean},
      {"EncoderError", Condition::kEncoder, kAuto,
       on_board([](EmulatedBoard& b) { b.encoder(3).broken_lines = true; }), Asked::kStop, 0,
       clean},
      {"EncoderSupply", Condition::kEncoder, kAuto,
       on_board([](EmulatedBoard& b) { b.faults.encoder_supply = true; }), Asked::kPowerOff, 0,
       clean},
      {"Reboot", Condition::kRebooted, kAuto,
       [](Rig& rig) {
         rig.emulator.board(1).reboot(static_cast<Ticks>(rig.link.now() * kTicksPerSecond));
       },
       Asked::kPowerOff, 0.0015, clean, true},
      {"TimestampZero", Condition::kTimestamp, kAuto,
       on_board([](EmulatedBoard& b) { b.faults.stops_clock = true; }), Asked::kGoOn, 0, clean},
      {"MissedCycles", Condition::kTimestamp, kQuery, [](Rig& rig) { rig.link.wait(0.005); },
       Asked::kGoOn, 0, clean},
      {"NotEffective", Condition::kNotEffective, kAuto,
       on_board([](EmulatedBoard& b) { b.faults.ignores_writes = true; }), Asked::kStop, 0.012,
       clean},
      {"OldReplies", Condition::kOldReplies, kAuto, reply(ReplyFault::kOld, -1), Asked::kStop, 0.012, clean},
      {"EthernetFlags", Condition::kEthernet, kAuto,
       [](Rig& rig) { rig.emulator.faults.flags = kFlagProtocolError; }, Asked::kGoOn, 0, clean},
      {"PacketErrors", Condition::kEthernet, kAuto,
       [](Rig& rig) { rig.emulator.faults.packet_errors = 3; }, Asked::kGoOn, 0, clean},
      {"EthernetRegister", Condition::kEthernet, kAuto,
       on_board([](EmulatedBoard& b) { b.ethernet |= 1U << 28; }), Asked::kGoOn, 0.28, clean},
      {"NotSent", Condition::kNotSent, kAuto, [](Rig& rig) { rig.link.cut = true; }, Asked::kStop,
       0.032, clean},
      {"ForeignSender", Condition::kForeignSender, kAuto,
       [](Rig& rig) {
         static const std::uint8_t kOther[28] = {1, 2, 3};
         rig.link.push({kOther, sizeof kOther}, false);
       },
       Asked::kGoOn, 0, clean},
      {"ForeignReply", Condition::kForeignSender, kAuto, reply(ReplyFault::kForeign, 1),
       Asked::kGoOn, 0, clean},
  };
  return kRows;
}

class ConditionOfSection17 : public testing::TestWithParam<Row> {};
INSTANTIATE_TEST_SUITE_P(Rows, ConditionOfSection17, testing::ValuesIn(rows()),
                         [](const auto& of) { return std::string(of.param.name); });

// While the bus is being reset no write gets through at all: the watchdog stops the motors.

// Currents that change in every cycle, so that a write that is lost shows.
double wave(int k) {
  return 1000.0 + (k % 50);
}

TEST_P(ConditionOfSection17, IsDetectedAndRestartsOnlyOnRequest) {
  const Row& row = GetParam();
  SessionOptions how = Rig::options(row.protocol);
  how.bus.repeat_after = 0.0;  // each of these replies is gone for good
  // The board's own check of 50 ms comes after the session's, which is left out to see it.
  if (row.condition == Condition::kCurrentTrip) how.follow.cycles = 1000;
  Rig rig(how);
  ASSERT_TRUE(rig.bring_up()) << rig.session.faults().report();
  for (int k = 0; k < 20; ++k) rig.cycle(wave(k));
  ASSERT_TRUE(rig.currents_flow());
  rig.session.faults().clear();

  row.inject(rig);
  const double start = rig.link.now();
  int cycles = 0;
  do {
    rig.cycle(wave(++cycles));
    if (row.asked != Asked::kGoOn && !rig.currents_flow() &&
        rig.session.state() == PowerState::kFault && rig.count(row.condition) > 0)
      break;
  } while (rig.link.now() - start < row.grace);
  EXPECT_GT(rig.count(row.condition), 0) << rig.session.faults().report();
  if (row.asked == Asked::kGoOn) {
    rig.cycles(3, 1234.0);
    EXPECT_EQ(rig.session.state(), PowerState::kOn) << rig.session.faults().report();
    EXPECT_TRUE(rig.currents_flow());
  } else {
    EXPECT_FALSE(rig.currents_flow()) << rig.session.faults().report();
    rig.cycles(1, 1234.0);
    EXPECT_EQ(rig.session.state(), PowerState::kFault) << rig.session.faults().report();
  }
  if (row.asked == Asked::kPowerOff) {
    for (int b = 0; b < 2; ++b) {
      EXPECT_FALSE(rig.emulator.board(b).status().power_requested()) << b;
    }
  }

  // After the cause is removed nothing restarts by itself, and everything restarts on request.
  row.remove(rig);
  for (int k = 0; k < 400; ++k) {
    rig.cycle(1234.0);
    ASSERT_TRUE(row.asked == Asked::kGoOn || !rig.currents_flow()) << k;
  }
  if (row.asked != Asked::kGoOn) {
    EXPECT_NE(rig.session.power_on(), nullptr);
    if (row.restart) {
      EXPECT_FALSE(rig.session.acknowledge());
      rig.session.start();
      rig.cycles(3);
    } else {
      ASSERT_TRUE(rig.session.acknowledge()) << rig.session.faults().report();
    }
    rig.cycles(5);
    ASSERT_TRUE(rig.power_up()) << rig.session.faults().report();
  }
  rig.cycles(3, 1500.0);
  EXPECT_EQ(rig.emulator.board(1).drive(0).bits, 1500.0);
}

// Every number of the list has its test: here, as a refusal, or below.
TEST(ConditionsOfSection17, AllHaveATestAndADescription) {
  std::vector<bool> tested(kConditions + 1, false);
  for (const Row& row : rows()) tested[static_cast<size_t>(row.condition)] = true;
  for (const int refusal : {10, 11, 12, 16, static_cast<int>(Condition::kPot), static_cast<int>(Condition::kLostReplies),
                            static_cast<int>(Condition::kStalled)})
    tested[static_cast<size_t>(refusal)] = true;
  for (int k = 1; k <= kConditions; ++k) {
    EXPECT_TRUE(tested[static_cast<size_t>(k)]) << k;
    EXPECT_STRNE(describe(static_cast<Condition>(k)), "");
  }
}

// Under any controller: a motor at rest with nearly its largest current, not one that moves
// with it, nor one that has less.
TEST(StallCheck, AStalledMotorIsSwitchedOff) {
  struct Case {
    double share, counts;  // of the largest current; per cycle
    bool stalls;
  };
  for (const Case& one : {Case{0.97, 0.0, true}, Case{-0.97, 0.0, true}, Case{0.93, 0.0, false}, Case{0.97, 1.0, false}}) {
    SessionOptions options = Rig::options();
    for (auto& board : options.channels)
      for (ChannelSafety& c : board) c.rest_counts = 100.0;
    Rig rig(options);
    ASSERT_TRUE(rig.bring_up());
    double moved = 0.0;
    int cycles = 0;
    for (; cycles < 1000 && rig.session.state() == PowerState::kOn; ++cycles) {
      moved += one.counts;
      if (moved >= 1.0) {
        for (int b = 0; b < 2; ++b)
          for (int c = 0; c < kChannels; ++c) rig.emulator.board(b).encoder(c).slip(1);
        moved -= 1.0;
      }
      rig.cycle(one.share * Rig::kLargest);
    }
    EXPECT_EQ(rig.session.state() == PowerState::kFault, one.stalls) << one.share;
    if (!one.stalls) continue;
    EXPECT_NEAR(cycles * Rig::kCycle, options.stall, 0.01);
    EXPECT_EQ(rig.session.cause(), Condition::kStalled);
    EXPECT_FALSE(rig.currents_flow());
  }
}

TEST(PotCheck, ALastingDifferenceOfPotAndEncoderSwitchesOff) {
  SessionOptions options = Rig::options();
  ChannelSafety& c = options.channels[0][0];
  c.counts_to_position = {1e-3, 0.0};
  c.pot_to_position = {1e-4, -3.2768};  // the pot of the emulator rests at 32768
  c.pot_tolerance = 0.05;
  Rig rig(options);
  ASSERT_TRUE(rig.bring_up());
  rig.cycles(30, 100.0);
  EXPECT_EQ(rig.session.state(), PowerState::kOn);
  rig.emulator.board(0).encoder(0).preload(preload_word(60));  // 0.06 off
  rig.cycles(10, 100.0);
  EXPECT_EQ(rig.session.state(), PowerState::kOn);
  rig.cycles(10, 100.0);
  EXPECT_EQ(rig.session.state(), PowerState::kFault);
  EXPECT_EQ(rig.session.cause(), Condition::kPot);
  EXPECT_FALSE(rig.currents_flow());
}

}  // namespace
}  // namespace veridyn::dvrk
