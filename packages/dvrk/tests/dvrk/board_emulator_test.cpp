#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include <array>

#include "dvrk/vectors.hpp"
#include "emulator/board_emulator.hpp"
#include "dvrk/protocol/hub_block.hpp"
#include "veridyn/math/require.hpp"

// The checklist of section 18, tested on the emulator with an injected clock.

namespace veridyn::dvrk {
namespace {

class EmulatorBench {
 public:
  explicit EmulatorBench(int firmware = 8, std::uint8_t generation = 3)
      : EmulatorBench({setup(6, firmware), setup(7, firmware)}, generation) {}
  explicit EmulatorBench(const std::vector<BoardSetup>& boards, std::uint8_t generation = 3)
      : emulator(boards, generation) {
    generation_ = generation;
    emulator.advance(0);
  }

  static BoardSetup setup(int id, int firmware) {
    BoardSetup s;
    s.id = id;
    s.firmware = firmware;
    s.qla_serial = "QLA 1234-56";
    return s;
  }

  void wait(double seconds) { now += static_cast<Ticks>(seconds * kTicksPerSecond); }

  // @returns whether there was an answer.
  bool send_query(const Request& request) {
    std::array<std::uint8_t, kDatagramBuffer> out{};
    const std::size_t size = encode(request, {out.data(), out.size()});
    return raw({out.data(), size});
  }

  bool raw(ByteView datagram) {
    const Answer answer = emulator.handle(datagram, now, {buffer.data(), buffer.size()});
    last = {buffer.data(), answer.size};
    if (answer.size == 0) return false;
    EXPECT_EQ(decode(last, reply), Malformed::kNone);
    return true;
  }

  Request request(Tcode tcode, int node, std::uint16_t address) {
    Request r;
    r.generation = generation_;
    r.node = static_cast<std::uint8_t>(node);
    r.label = ++label & 0x3F;
    r.tcode = tcode;
    r.address = address;
    return r;
  }

  std::uint32_t read(int node, std::uint16_t address) {
    EXPECT_TRUE(send_query(request(Tcode::kQuadletRead, node, address)));
    EXPECT_EQ(reply.label, label & 0x3F);
    return reply.data;
  }

  void write(int node, std::uint16_t address, std::uint32_t data) {
    Request r = request(Tcode::kQuadletWrite, node, address);
    r.data = data;
    EXPECT_FALSE(send_query(r));  // writes are never answered
  }

  BoardFeedback feedback(int node) {
    const int firmware = emulator.board(node).setup().firmware;
    Request r = request(Tcode::kBlockRead, node, 0);
    r.bytes = static_cast<std::uint16_t>(4 * read_quadlets(firmware));
    EXPECT_TRUE(send_query(r));
    return decode_feedback(reply.block, firmware);
  }

  void command(int node, const BoardCommand& c) {
    const int firmware = emulator.board(node < 2 ? node : 0).setup().firmware;
    std::array<std::uint8_t, 24> block{};
    encode_command(c, firmware, QuadletSpan({block.data(), block.size()}));
    Request r = request(Tcode::kBlockWrite, node, 0);
    r.block = QuadletView({block.data(), 4 * write_quadlets(firmware)});
    EXPECT_FALSE(send_query(r));
  }

  Status status(int node) { return {read(node, 0)}; }

  // Relay, power, 0.1 s, amplifiers with this current, 50 ms.
  void bring_up(std::uint16_t dac = kZeroCurrent) {
    for (int node : {0, 1}) write(node, 0, control::kRelayClose);
    for (int node : {0, 1}) write(node, 0, control::kPowerOn);
    for (int k = 0; k < 10; ++k) keep_alive(0.01);
    for (int node : {0, 1}) command(node, amps_on(node, dac));
    for (int k = 0; k < 5; ++k) keep_alive(0.01);
  }

  BoardCommand amps_on(int node, std::uint16_t dac) {
    BoardCommand c;
    c.board = static_cast<std::uint8_t>(emulator.board(node).setup().id);
    for (ChannelCommand& channel : c.channel) channel = {true, false, AmpRequest::kOn, 0, dac};
    return c;
  }

  void keep_alive(double seconds) {
    wait(seconds);
    for (int node : {0, 1}) write(node, 0, 0);
  }

  BoardEmulator emulator;
  Ticks now = 0;
  std::uint8_t label = 0;
  std::uint8_t generation_;
  Reply reply;
  ByteView last;
  std::array<std::uint8_t, kDatagramBuffer> buffer{};
};

TEST(BoardEmulator, ReplaysTheCapturedSessionStart) {
  EmulatorBench bench;
  bench.wait(0.05);  // the watchdog of a fresh board has run out
  const Vector* request = nullptr;
  int answers = 0;
  for (const Vector& v : vectors()) {
    if (v.section != "19.1" && v.section != "19.2" && v.section != "19.4") continue;
    if (v.direction == Direction::kToBoard) {
      if (v.section == "19.4") {
        const auto prom =
            bytes_of(vector_named("19.3", "QLA PROM read command (3 quadlets from 0)").hex);
        EXPECT_FALSE(bench.raw({prom.data(), prom.size()}));
        bench.wait(0.001);
      }
      request = &v;
      bench.wait(0.04);
      const auto bytes = bytes_of(v.hex);
      bench.raw({bytes.data(), bytes.size()});
      continue;
    }
    // Their responder writes no CRC for board 7 either, which a host does not check.
    std::array<std::uint8_t, kDatagramBuffer> plain{};
    const std::size_t size = encode(bench.reply, Crc::kZero, {plain.data(), plain.size()});
    EXPECT_EQ(hex_of({plain.data(), size}), v.hex) << "to " << request->hex;
    ++answers;
  }
  EXPECT_EQ(answers, 6);
  EXPECT_EQ(bench.emulator.board(0).ip_address, 0x0100007FU);
  EXPECT_EQ(bench.emulator.counters().wrong_crc, 0);
}

TEST(BoardEmulator, OnlyExistingNodesAnswerReads) {
  EmulatorBench bench;
  EXPECT_EQ(bench.read(0, address::kHardware), kHardwareQla1);
  EXPECT_EQ(bench.reply.header_crc, 0U);  // of the hub
  EXPECT_EQ(bench.read(1, address::kFirmware), 8U);
  EXPECT_NE(bench.reply.header_crc, 0U);  // relayed
  EXPECT_TRUE(bench.reply.crc_right);
  EXPECT_FALSE(bench.send_query(bench.request(Tcode::kQuadletRead, 2, 0)));
  Request local = bench.request(Tcode::kQuadletRead, 1, 0);
  local.flags = kNoForward;
  EXPECT_FALSE(bench.send_query(local));
  EXPECT_TRUE(bench.send_query(bench.request(Tcode::kQuadletRead, kBroadcastNode, 0)));
  EXPECT_EQ(bench.reply.node, 0);
}

TEST(BoardEmulator, AStaleGenerationAnswersReadsWithAnErrorAndDropsWrites) {
  EmulatorBench bench;
  bench.emulator.bus_reset();
  BoardCommand c = bench.amps_on(0, 0x9000);
  bench.command(0, c);
  EXPECT_EQ(bench.emulator.board(0).dac(0), kZeroCurrent);
  Request r = bench.request(Tcode::kBlockRead, 0, 0);
  r.bytes = 128;
  EXPECT_TRUE(bench.send_query(r));
  EXPECT_EQ(hex_of(bench.last), vector_named("19.9", "reply (8 bytes)").hex);
  bench.command(kBroadcastNode, c);  // exempt
  EXPECT_EQ(bench.emulator.board(0).dac(0), 0x9000);
  bench.emulator.bus_reset(0.1, {1, 0});
  bench.generation_ = bench.emulator.generation();
  EXPECT_TRUE(bench.send_query(r));
  EXPECT_EQ(bench.reply.trailer.flags, kFlagDropped | kFlagBusReset);
  bench.wait(0.2);
  EXPECT_EQ(bench.status(0).board(), 7);  // nodes have changed places
}

TEST(BoardEmulator, WatchdogTripsAfterItsTimeAndLatchesUntilEnabled) {
  EmulatorBench bench;
  bench.bring_up(0x8100);
  EXPECT_TRUE(bench.emulator.board(0).amp_on(0));
  bench.wait(0.029);
  EXPECT_TRUE(bench.emulator.board(0).amp_on(0));
  bench.feedback(0);  // reads do not help
  bench.wait(0.002);
  EXPECT_EQ(bench.status(0).word & 0xFFFFBFFF, 0x46BF0000U);  // section 14.1, but the chain's bit
  bench.keep_alive(0.01);
  EXPECT_TRUE(bench.status(0).watchdog());
  EXPECT_FALSE(bench.emulator.board(0).amp_on(0));
  EXPECT_EQ(bench.emulator.board(0).dac(0), 0x8100);
  bench.command(0, bench.amps_on(0, kZeroCurrent));
  bench.wait(0.001);
  EXPECT_FALSE(bench.status(0).watchdog());
  EXPECT_TRUE(bench.emulator.board(0).amp_on(0));
}

TEST(BoardEmulator, AmplifiersIgnoreTheFirstPowerPacketAndWait40Milliseconds) {
  EmulatorBench bench;
  for (int node : {0, 1}) bench.write(node, 0, control::kRelayClose);
  BoardCommand both = bench.amps_on(0, kZeroCurrent);
  both.control = control::kPowerOn;
  bench.command(0, both);
  for (int k = 0; k < 20; ++k) bench.keep_alive(0.01);
  EXPECT_FALSE(bench.emulator.board(0).motor_status(0).amp_requested());  // section 10.5
  bench.write(0, 0, control::kPowerOff);
  bench.keep_alive(0.01);
  bench.write(0, 0, control::kPowerOn);
  bench.command(0, bench.amps_on(0, kZeroCurrent));
  bench.keep_alive(0.02);
  bench.keep_alive(0.02);
  EXPECT_TRUE(bench.status(0).supply_good());
  EXPECT_FALSE(bench.emulator.board(0).amp_on(0));
  EXPECT_TRUE(bench.emulator.board(0).motor_status(0).amp_requested());
  for (int k = 0; k < 3; ++k) bench.keep_alive(0.01);
  EXPECT_TRUE(bench.emulator.board(0).amp_on(0));
}

TEST(BoardEmulator, AnEmergencyStopRemovesAndRestoresTheVoltage) {
  EmulatorBench bench;
  bench.bring_up();
  bench.emulator.chain.emergency_stop = true;
  bench.keep_alive(0.001);
  const Status stopped = bench.status(1);
  EXPECT_FALSE(stopped.supply_good());
  EXPECT_TRUE(stopped.power_requested() && stopped.relay_closed());
  EXPECT_FALSE(bench.emulator.board(1).amp_on(0));
  bench.emulator.chain.emergency_stop = false;
  for (int k = 0; k < 10; ++k) bench.keep_alive(0.01);
  // The amplifier switches on again by itself after an emergency stop: clients must disable it first.
  EXPECT_TRUE(bench.emulator.board(1).amp_on(0));
}

TEST(BoardEmulator, OneOpenRelayRemovesTheVoltageOfAllBoards) {
  EmulatorBench bench;
  bench.bring_up();
  bench.write(1, 0, control::kRelayOpen);
  bench.keep_alive(0.001);
  EXPECT_FALSE(bench.status(0).supply_good());
  EXPECT_TRUE(bench.status(0).relay_closed());
}

TEST(BoardEmulator, AnExcessCurrentTripsAfter50Milliseconds) {
  EmulatorBench bench;
  bench.bring_up(0x8100);
  bench.emulator.board(0).faults.current[2] = 0x901;
  for (int k = 0; k < 4; ++k) bench.keep_alive(0.01);
  EXPECT_FALSE(bench.status(0).current_trip(2));
  for (int k = 0; k < 3; ++k) bench.keep_alive(0.01);
  EXPECT_TRUE(bench.status(0).current_trip(2));
  EXPECT_FALSE(bench.emulator.board(0).amp_on(2));
  EXPECT_TRUE(bench.emulator.board(0).amp_on(1));
}

class BoardEmulatorOfEveryFirmware : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Firmware, BoardEmulatorOfEveryFirmware, testing::Values(6, 7, 8, 9),
                         [](const auto& of) { return "Rev" + std::to_string(of.param); });

TEST_P(BoardEmulatorOfEveryFirmware, FeedbackShowsTheCommands) {
  EmulatorBench bench(GetParam());
  for (int node : {0, 1}) bench.write(node, 0, control::kRelayClose);
  for (int node : {0, 1}) bench.write(node, 0, control::kPowerOn);
  for (int k = 0; k < 10; ++k) bench.keep_alive(0.01);
  bench.command(1, bench.amps_on(1, 0x8123));
  if (GetParam() == 6) bench.write(1, 0, control::kAmpsOn);  // not part of its blocks
  for (int k = 0; k < 5; ++k) bench.keep_alive(0.01);
  bench.feedback(1);
  bench.wait(0.001);
  const BoardFeedback f = bench.feedback(1);
  EXPECT_NEAR(f.seconds(), 0.001, 1e-7);
  EXPECT_EQ(f.status.board(), 7);
  for (int c = 0; c < kChannels; ++c) {
    EXPECT_TRUE(f.status.amp_on(c));
    EXPECT_EQ(f.channel[c].current, 0x8123);
    EXPECT_EQ(bench.read(1, address::of_channel(c, address::kDac)) & 0xFFFF, 0x8123U);
    EXPECT_EQ(bench.emulator.board(0).dac(c), kZeroCurrent);
  }
}

TEST_P(BoardEmulatorOfEveryFirmware, TheHubHasTheBlocksOfAllBoardsInAscendingOrder) {
  const int firmware = GetParam();
  if (firmware < 7) GTEST_SKIP() << "its broadcast has another layout";
  EmulatorBench bench({EmulatorBench::setup(9, firmware), EmulatorBench::setup(4, firmware)});
  bench.write(kBroadcastNode, address::kHubQuery, query_word(0x1234, (1U << 4) | (1U << 9)));
  Request r = bench.request(Tcode::kBlockRead, 0, address::kHub);
  const std::size_t each = hub_quadlets(firmware);
  r.bytes = static_cast<std::uint16_t>(4 * (2 * each + 1));
  bench.send_query(r);  // too early: nothing has come yet
  EXPECT_EQ(bench.reply.block[0], 0U);
  bench.wait(20e-6);
  ASSERT_TRUE(bench.send_query(r));
  for (std::size_t b = 0; b < 2; ++b) {
    const HubHeader h = decode_hub_header(bench.reply.block[b * each], firmware);
    EXPECT_TRUE(answers(h, 0x1234, firmware));
    const BoardFeedback f =
        decode_feedback(bench.reply.block.part(b * each + 1, each - 1), firmware);
    EXPECT_EQ(f.status.board(), b == 0 ? 4 : 9);
  }
  EXPECT_NEAR(bench.reply.block[2 * each] >> 16, 983, 1);
  // The next query does not count before it was answered.
  bench.write(kBroadcastNode, address::kHubQuery, query_word(0x1235, (1U << 4) | (1U << 9)));
  ASSERT_TRUE(bench.send_query(r));
  EXPECT_TRUE(answers(decode_hub_header(bench.reply.block[0], firmware), 0x1234, firmware));
}

TEST(BoardEmulator, RegistersKeepWrittenValues) {
  EmulatorBench bench;
  bench.write(0, address::kWatchdog, 57600);
  EXPECT_EQ(bench.read(0, address::kWatchdog), 57600U);
  bench.write(1, address::of_channel(0, address::kPreload), preload_word(1000));
  EXPECT_EQ(bench.read(1, address::of_channel(0, address::kPreload)), 0x008003E8U);
  EXPECT_EQ(encoder_counts(bench.feedback(1).channel[0].encoder.position), 1000);
  bench.write(0, address::kDigitalOut, digital_output_word(0x3, 0x1));
  EXPECT_EQ(bench.feedback(0).digital.outputs(), 0xDU);
  EXPECT_EQ(bench.read(0, address::of_channel(2, address::kMotorConfig)), kMotorConfigDefault);
  EXPECT_EQ(bench.read(0, 0x00F0), 0U);  // no register is there
  bench.write(0, address::kFpgaPromCommand, 0x03000000 | 0x1FFF00);
  EXPECT_EQ(bench.read(0, address::kFpgaPromResult), 64U);
  Request r = bench.request(Tcode::kBlockRead, 0, address::kFpgaPromData);
  r.bytes = 12;
  ASSERT_TRUE(bench.send_query(r));
  EXPECT_EQ(bench.reply.block[0], 0x46504741U);  // "FPGA"
  bench.write(0, address::kFpgaPromCommand, 0x9F000000);
  EXPECT_EQ(bench.read(0, address::kFpgaPromResult), 0x00202015U);
  for (std::uint32_t k = 0; k < 3; ++k) {  // "QLA", byte by byte
    bench.write(0, address::kQlaPromCommand, 0x03000000U | (k << 8));
    EXPECT_EQ(bench.read(0, 0x3002), static_cast<std::uint32_t>("QLA"[k]));
  }
  bench.write(0, 0x8005, 0x12345678);  // waveform table
  EXPECT_EQ(bench.read(0, 0x8005), 0x12345678U);
  EXPECT_EQ(bench.read(0, address::kDallas), 9U);  // enabled, both directions, no instrument
  const std::uint8_t generation = bench.emulator.generation();
  bench.write(0, 0, control::kReboot);
  EXPECT_EQ(bench.emulator.generation(), generation + 1);  // the bus is reset because of it
  EXPECT_EQ(bench.emulator.board(0).read(address::kWatchdog), kWatchdogDefault);
}

TEST(BoardEmulator, AnInstrumentsMemoryChipCanBeRead) {
  BoardSetup setup;
  setup.dallas.resize(256);
  for (std::size_t k = 0; k < 256; ++k) setup.dallas[k] = static_cast<std::uint8_t>(k);
  EmulatedBoard board(setup);
  EXPECT_EQ(board.read(address::kDallas) >> 24, 0x0BU);  // DS2505
  std::array<std::uint8_t, 16> out{};
  board.read_block(0x6001, QuadletSpan({out.data(), out.size()}));
  EXPECT_EQ(out[0], 4);
  EXPECT_EQ(out[15], 19);
}

// Noise has the given deviation and no mean.
TEST(BoardEmulator, PotsAndCurrentsHaveTheRequestedNoise) {
  BoardSetup setup;
  setup.pot_noise = 3.0;
  setup.current_noise = 5.0;
  EmulatedBoard board(setup);
  double sum[2] = {0, 0}, squares[2] = {0, 0};
  constexpr int kReadings = 20000;
  for (int k = 0; k < kReadings; ++k) {
    board.set_motion(1, {0.0, 30000.0, 100.0});
    const BoardFeedback f = board.latch();
    const double off[2] = {f.channel[1].pot - 30000.0, f.channel[1].current - 32868.0};
    for (int i = 0; i < 2; ++i) {
      sum[i] += off[i];
      squares[i] += off[i] * off[i];
    }
  }
  // Three standard deviations of the mean, and 3 % of the deviation; rounding adds 1/12 bit^2.
  EXPECT_NEAR(sum[0] / kReadings, 0.0, 3.0 * 3.0 / std::sqrt(kReadings));
  EXPECT_NEAR(sum[1] / kReadings, 0.0, 3.0 * 5.0 / std::sqrt(kReadings));
  EXPECT_NEAR(std::sqrt(squares[0] / kReadings - 1.0 / 12), 3.0, 0.1);
  EXPECT_NEAR(std::sqrt(squares[1] / kReadings - 1.0 / 12), 5.0, 0.15);
}

TEST(BoardEmulator, BadSetupsAreRefusedWithAReason) {
  const auto with = [](int id, int firmware) {
    BoardSetup s;
    s.id = id;
    s.firmware = firmware;
    return s;
  };
  EXPECT_THROW(BoardEmulator({}), InvalidInput);
  EXPECT_THROW(BoardEmulator({with(3, 8), with(3, 8)}), InvalidInput);
  EXPECT_THROW(BoardEmulator({with(16, 8)}), InvalidInput);
  EXPECT_THROW(BoardEmulator({with(1, 5)}), InvalidInput);
}

}  // namespace
}  // namespace veridyn::dvrk
