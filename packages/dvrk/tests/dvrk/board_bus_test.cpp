#include "dvrk/boards/board_bus.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "dvrk/rig.hpp"
#include "dvrk/vectors.hpp"
#include "support/malloc_count.hpp"
#include "veridyn/math/require.hpp"
#include "support/refusal.hpp"

namespace veridyn::dvrk {

long dvrk_malloc_count() {
  return VERIDYN_COUNTS_MALLOC == 0 ? -1 : malloc_count();
}

namespace {

// Records the datagrams that the client sends.
class Witness final : public DatagramLink {
 public:
  explicit Witness(DatagramLink& link) : link_(link) {}
  bool send(ByteView datagram, Destination to) noexcept override {
    sent.push_back(hex_of(datagram));
    destinations.push_back(to);
    return link_.send(datagram, to);
  }
  Arrival receive(ByteSpan buffer, double timeout) noexcept override {
    return link_.receive(buffer, timeout);
  }
  double now() noexcept override { return link_.now(); }
  void wait(double seconds) noexcept override { link_.wait(seconds); }
  std::uint32_t address_word() const noexcept override { return link_.address_word(); }

  std::vector<std::string> sent;
  std::vector<Destination> destinations;

 private:
  DatagramLink& link_;
};

BusOptions both_boards() {
  BusOptions options;
  options.boards = {7, 6};
  return options;
}

// Section 19.1: the datagrams that the laboratory's host sends at its start.
TEST(BoardBus, StartSendsTheDatagramsOfTheDvrkHostSoftware) {
  BoardEmulator emulator({Rig::setup(6), Rig::setup(7)}, 3);
  EmulatedLink link(emulator);
  Witness witness(link);
  BoardBus bus(witness, both_boards());
  bus.start();
  size_t k = 0;
  for (const Vector& v : vectors()) {
    if (v.section != "19.1" || v.direction != Direction::kToBoard) continue;
    ASSERT_LT(k, witness.sent.size());
    EXPECT_EQ(witness.sent[k], v.hex);
    EXPECT_EQ(witness.destinations[k], Destination::kEveryone);
    ++k;
  }
  EXPECT_EQ(k, 6U);
  EXPECT_EQ(bus.state(), BusState::kRunning);
  EXPECT_EQ(bus.info(0).id, 6);
  EXPECT_EQ(bus.info(1).node, 1);
  EXPECT_EQ(bus.protocol(), CycleProtocol::kBroadcastWrite);
}

class BusOfEveryKind : public testing::TestWithParam<std::tuple<int, CycleProtocol>> {};
INSTANTIATE_TEST_SUITE_P(Kinds, BusOfEveryKind,
                         testing::Combine(testing::Values(6, 7, 8, 9),
                                          testing::Values(CycleProtocol::kSequential,
                                                          CycleProtocol::kBroadcastWrite,
                                                          CycleProtocol::kBroadcast)),
                         [](const auto& of) {
                           return "Rev" + std::to_string(std::get<0>(of.param)) + "Protocol" +
                                  std::to_string(static_cast<int>(std::get<1>(of.param)));
                         });

TEST_P(BusOfEveryKind, SendsCommandsAndReceivesFeedback) {
  const auto [firmware, protocol] = GetParam();
  // Ids against the order of nodes; the hub is the board with the larger id.
  BoardEmulator emulator({Rig::setup(9, firmware), Rig::setup(4, firmware)}, 3);
  EmulatedLink link(emulator);
  BusOptions options;
  options.boards = {9, 4};
  options.protocol = protocol;
  BoardBus bus(link, options);
  if (firmware == 6 && protocol == CycleProtocol::kBroadcast) {
    EXPECT_THROW(bus.start(), InvalidInput);
    return;
  }
  bus.start();
  ASSERT_TRUE(bus.set_watchdog(0.1));
  for (int k = 0; k < 20; ++k) {
    link.wait(0.0005);
    ASSERT_TRUE(bus.read()) << bus.faults().report();
    for (int b = 0; b < 2; ++b) {
      for (size_t c = 0; c < kChannels; ++c) {
        const auto value =
            static_cast<std::uint16_t>(0x8000 + 100 * k + 10 * b + static_cast<int>(c));
        bus.command(b).channel[c] = {true, false, AmpRequest::kKeep, 0, value};
      }
    }
    bus.write();
    for (int b = 0; b < 2; ++b) {
      const int place = b == 0 ? 1 : 0;  // board 4 is the second node
      EXPECT_EQ(bus.feedback(b).status.board(), b == 0 ? 4 : 9);
      for (int c = 0; c < kChannels; ++c)
        EXPECT_EQ(emulator.board(place).dac(c), 0x8000 + 100 * k + 10 * b + c);
    }
  }
  EXPECT_EQ(bus.faults().report(), "");
}

TEST_P(BusOfEveryKind, TheCycleDoesNotAllocate) {
  if (VERIDYN_COUNTS_MALLOC == 0) GTEST_SKIP() << "the sanitizer has a malloc of its own";
  const auto [firmware, protocol] = GetParam();
  if (firmware == 6 && protocol == CycleProtocol::kBroadcast) GTEST_SKIP() << "refused";
  const long at_start = malloc_count();
  Rig rig(protocol, {Rig::setup(6, firmware), Rig::setup(7, firmware)});
  EXPECT_GT(malloc_count(), at_start) << "the counter does not count";
  ASSERT_TRUE(rig.bring_up()) << rig.session.faults().report();
  const long before = malloc_count();
  rig.cycles(1000, 100.0);
  EXPECT_EQ(malloc_count(), before);
  rig.emulator.bus_reset();  // nor does the search for boards that have moved
  rig.cycles(100);
  EXPECT_EQ(malloc_count(), before);
  EXPECT_EQ(rig.session.bus().state(), BusState::kRunning);
}

TEST(BoardBus, RenumberedNodesAreFoundAgain) {
  Rig rig;
  ASSERT_TRUE(rig.bring_up());
  rig.emulator.bus_reset(0.0, {5, 2});
  EXPECT_FALSE(rig.cycle());
  EXPECT_EQ(rig.session.bus().state(), BusState::kScanning);
  double longest = 0.0;
  for (int k = 0; k < 100 && rig.session.bus().state() != BusState::kRunning; ++k) {
    const double before = rig.link.now();
    rig.cycle();
    longest = std::max(longest, rig.link.now() - before);
  }
  EXPECT_EQ(rig.session.bus().state(), BusState::kRunning);
  EXPECT_EQ(rig.session.bus().info(0).node, 5);
  EXPECT_EQ(rig.session.bus().info(1).node, 2);
  EXPECT_LT(longest, 0.030);  // the watchdog is fed all the time
  EXPECT_TRUE(rig.cycle());
}

std::string refusal(const BusOptions& options, const std::vector<BoardSetup>& boards,
                    const std::function<void(BoardEmulator&)>& spoil = nullptr) {
  BoardEmulator emulator(boards, 3);
  if (spoil) spoil(emulator);
  EmulatedLink link(emulator);
  return veridyn::refusal([&] {
    BoardBus bus(link, options);
    bus.start();
  });
}

TEST(BoardBus, UnsupportedBoardsAreRefusedByName) {
  const BusOptions two = both_boards();
  EXPECT_EQ(refusal(two, {Rig::setup(6), Rig::setup(7)}), "");
  EXPECT_NE(refusal(two, {Rig::setup(6), Rig::setup(8)}).find("board 7 does not answer"),
            std::string::npos);
  // 10
  BoardSetup odd = Rig::setup(7);
  odd.hardware = 0x54455354;
  EXPECT_NE(refusal(two, {Rig::setup(6), odd}).find("0x54455354"), std::string::npos);
  const auto five_channels = [](BoardEmulator& e) { e.board(0).faults.wrong_channels = 5; };
  EXPECT_NE(refusal(two, {Rig::setup(6), Rig::setup(7)}, five_channels).find("5 channels"),
            std::string::npos);
  // 11
  BusOptions broadcast = two;
  broadcast.protocol = CycleProtocol::kBroadcast;
  EXPECT_NE(refusal(broadcast, {Rig::setup(6, 7), Rig::setup(7, 8)}).find("several groups"),
            std::string::npos);
  EXPECT_EQ(refusal(two, {Rig::setup(6, 7), Rig::setup(7, 8)}), "");  // sequential then
  // 12
  const auto twice = [](BoardEmulator& e) { e.board(1).faults.wrong_id = 6; };
  EXPECT_NE(refusal(two, {Rig::setup(6), Rig::setup(7)}, twice).find("id 6 on two nodes"),
            std::string::npos);
  // 16
  std::vector<BoardSetup> many;
  BusOptions all;
  all.protocol = CycleProtocol::kBroadcast;
  for (int id = 0; id < 11; ++id) {
    many.push_back(Rig::setup(id));
    all.boards.push_back(id);
  }
  EXPECT_NE(refusal(all, many).find("1456 bytes"), std::string::npos) << refusal(all, many);
  many.pop_back();
  all.boards.pop_back();
  EXPECT_EQ(refusal(all, many), "");
}

TEST(BoardBus, BoardsOfMixedFirmwareAreReadOneByOne) {
  Rig rig(CycleProtocol::kAutomatic, {Rig::setup(6, 7), Rig::setup(7, 8)});
  ASSERT_TRUE(rig.bring_up()) << rig.session.faults().report();
  EXPECT_EQ(rig.session.bus().protocol(), CycleProtocol::kSequential);
  rig.cycles(10, 300.0);
  for (int b = 0; b < 2; ++b) EXPECT_EQ(rig.emulator.board(b).drive(1).bits, 300.0);
  rig.session.shutdown();
  EXPECT_FALSE(rig.any_amp_on());
}

TEST(BoardBus, BadOptionsAreRefused) {
  BoardEmulator emulator({Rig::setup(6)}, 3);
  EmulatedLink link(emulator);
  BusOptions options;
  EXPECT_THROW(BoardBus(link, options), InvalidInput);
  options.boards = {6, 6};
  EXPECT_THROW(BoardBus(link, options), InvalidInput);
  options.boards = {16};
  EXPECT_THROW(BoardBus(link, options), InvalidInput);
  options.boards = {6};
  link.cut = true;
  BoardBus bus(link, options);
  EXPECT_THROW(bus.start(), InvalidInput);
}

// Boards that never answer, with a clock that waits move.
class Silence final : public DatagramLink {
 public:
  bool send(ByteView, Destination) noexcept override {
    sent.push_back(1e3 * now_);
    return true;
  }
  Arrival receive(ByteSpan, double timeout) noexcept override {
    now_ += timeout;
    return {};
  }
  double now() noexcept override { return now_; }
  void wait(double seconds) noexcept override { now_ += seconds; }
  std::uint32_t address_word() const noexcept override { return 0; }
  std::vector<double> sent;  // [ms]

 private:
  double now_ = 1.0;
};

// A first miss waits longer than a tick of the system's clock, later ones 1, 3, 7, 15 ms; after ten
// seconds without a miss it is a first one again.
TEST(Exchange, ARequestIsRepeatedSoonerAfterALostReply) {
  Silence link;
  FaultLog log;
  Exchange exchange(link, log);
  exchange.repeat_after(0.001);
  const auto pauses = [&](double timeout) {
    link.sent.clear();
    std::uint32_t value = 0;
    EXPECT_EQ(exchange.read(Route{}, address::kStatus, timeout, value), ReadResult::kNoReply);
    std::vector<double> after;
    for (const double at : link.sent) after.push_back(std::round(at - link.sent.front()));
    return after;
  };
  EXPECT_EQ(pauses(0.012), (std::vector<double>{0, 5, 7, 11}));
  EXPECT_EQ(pauses(0.010), (std::vector<double>{0, 1, 3, 7}));
  link.wait(11.0);
  EXPECT_EQ(pauses(0.004), (std::vector<double>{0}));
  EXPECT_EQ(pauses(0.004), (std::vector<double>{0, 1, 3}));
}

// A node's number is another board's after a reset that swaps them: a preload would make that board's position wrong.
TEST(BoardBus, RegistersAreNotWrittenWhileNodesAreUnknown) {
  Rig rig;
  rig.session.start();
  rig.cycles(5);
  ASSERT_EQ(rig.session.bus().info(0).node, 0);
  rig.emulator.bus_reset(0.0, {1, 0});
  rig.cycles(3);
  ASSERT_EQ(rig.session.bus().state(), BusState::kScanning);
  EXPECT_FALSE(rig.session.preload(0, 1, 1234));
  std::uint32_t value = 0;
  EXPECT_FALSE(rig.session.bus().read_register(0, address::kStatus, value));
  for (int k = 0; k < 100 && rig.session.bus().state() != BusState::kRunning; ++k) rig.cycle();
  ASSERT_EQ(rig.session.bus().info(0).node, 1);
  EXPECT_TRUE(rig.session.needs_preload(0, 1));
  EXPECT_TRUE(rig.session.needs_preload(1, 1));
  EXPECT_TRUE(rig.session.preload(0, 1, 1234));
  EXPECT_FALSE(rig.session.needs_preload(0, 1));
  EXPECT_TRUE(rig.session.needs_preload(1, 1));
}

// Board 7 is another arm's, and a reset gives it the node that board 6 had. Until board 6 is found again its own number is
// that of the other arm, which would fall: off goes by broadcast, in blocks that name the board.
TEST(BoardBus, PowerOffNeverReachesTheOtherArmWhileNodeNumbersAreUnknown) {
  BoardEmulator emulator({Rig::setup(6), Rig::setup(7)}, 3);
  EmulatedLink link(emulator);
  BusOptions options = both_boards();
  options.boards = {6};
  BoardBus bus(link, options);
  bus.start();
  const auto are_on = [&](bool six) {
    EXPECT_EQ(emulator.board(0).amp_on(0), six);
    EXPECT_EQ(emulator.board(0).status().power_requested(), six);
    EXPECT_TRUE(emulator.board(1).amp_on(0));
    EXPECT_TRUE(emulator.board(1).status().power_requested());
  };
  const auto switch_on = [&] {
    for (const std::uint32_t word : {control::kRelayClose, control::kPowerOn, control::kAmpsOn}) {
      for (int b = 0; b < 2; ++b) {
        emulator.board(b).write(address::kWatchdog, 0);
        emulator.board(b).write(address::kStatus, word);
      }
      link.wait(0.1);
    }
  };
  switch_on();
  are_on(true);
  emulator.bus_reset(0.0, {1, 0});
  for (int k = 0; bus.state() != BusState::kRunning || k < 2; ++k) {
    ASSERT_LT(k, 100);
    bus.read();
    if (bus.state() == BusState::kRunning) continue;
    EXPECT_FALSE(bus.switch_off_by_register(0, BoardBus::Off::kPower)) << k;
    are_on(true);
  }
  EXPECT_EQ(bus.info(0).node, 1);
  EXPECT_TRUE(bus.switch_off_by_register(0, BoardBus::Off::kPower));
  are_on(false);
  switch_on();
  emulator.bus_reset(0.0, {0, 1});
  bus.read();
  ASSERT_EQ(bus.state(), BusState::kScanning);
  bus.switch_off(BoardBus::Off::kPower);
  are_on(false);
}

// Fails a given number of sends.
class Stutter final : public DatagramLink {
 public:
  explicit Stutter(DatagramLink& link) : link_(link) {}
  bool send(ByteView datagram, Destination to) noexcept override {
    return failing > 0 ? --failing < 0 : link_.send(datagram, to);
  }
  Arrival receive(ByteSpan buffer, double timeout) noexcept override { return link_.receive(buffer, timeout); }
  double now() noexcept override { return link_.now(); }
  void wait(double seconds) noexcept override { link_.wait(seconds); }
  std::uint32_t address_word() const noexcept override { return link_.address_word(); }
  int failing = 0;

 private:
  DatagramLink& link_;
};

TEST(BoardBus, AFailedSendToOneBoardIsReportedAsALostLink) {
  BoardEmulator emulator({Rig::setup(6), Rig::setup(7)}, 3);
  EmulatedLink good(emulator);
  Stutter link(good);
  BoardBus bus(link, both_boards());
  bus.start();
  EXPECT_TRUE(bus.read());
  EXPECT_FALSE(bus.link_lost());
  link.failing = 1;  // of two
  EXPECT_FALSE(bus.read());
  EXPECT_FALSE(bus.valid(0));
  EXPECT_TRUE(bus.valid(1));
  EXPECT_TRUE(bus.link_lost());
  EXPECT_TRUE(bus.read());
  EXPECT_FALSE(bus.link_lost());
}

// Datagrams from elsewhere, one after the other for very long.
class Flood final : public DatagramLink {
 public:
  bool send(ByteView, Destination) noexcept override { return true; }
  Arrival receive(ByteSpan, double timeout) noexcept override {
    if (timeout > 0.0) now_ += 1e-4;
    return {++received <= 100000, 28, false, 0.0};
  }
  double now() noexcept override { return now_; }
  void wait(double seconds) noexcept override { now_ += seconds; }
  std::uint32_t address_word() const noexcept override { return 0; }
  long received = 0;

 private:
  double now_ = 1.0;
};

// 64 packets are discarded before the request, 200 until the timeout, and 64 after it.
TEST(Exchange, AFloodOfForeignPacketsDoesNotExtendTheTimeout) {
  Flood link;
  FaultLog log;
  Exchange exchange(link, log);
  std::uint32_t value = 0;
  EXPECT_EQ(exchange.read(Route{}, address::kStatus, 0.020, value), ReadResult::kNoReply);
  EXPECT_LE(link.received, 64 + 201 + 66);
  EXPECT_EQ(log.count(Condition::kNoReply), 1);
}

}  // namespace
}  // namespace veridyn::dvrk
