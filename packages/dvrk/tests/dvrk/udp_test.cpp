#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <thread>

#include "dvrk/rig.hpp"
#include "emulator/board_server.hpp"
#include "dvrk/protocol/udp_link.hpp"
#include "veridyn/math/require.hpp"

// The real sockets, over loopback, in real time.

namespace veridyn::dvrk {
namespace {

class Served : public testing::Test {
 protected:
  Served() : emulator_({Rig::setup(6), Rig::setup(7)}), server_(emulator_, 0) {
    thread_ = std::thread([this] { server_.run(stop_); });
  }
  ~Served() override {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }

  BoardEmulator emulator_;
  BoardServer server_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

TEST_F(Served, ASessionOverUdpPowersUpDrivesAndPowersDown) {
  for (const CycleProtocol protocol :
       {CycleProtocol::kSequential, CycleProtocol::kBroadcastWrite, CycleProtocol::kBroadcast}) {
    UdpLink link("127.0.0.1", server_.port());
    SessionOptions options = Rig::options(protocol);
    options.bus.cycle_time = 0.0;  // a busy machine misses some
    options.watchdog = 0.3;
    BoardSession session(link, options);
    session.start();
    bool asked = false;
    long driven = 0;
    const double until = link.now() + 5.0;
    while (link.now() < until && driven < 50) {
      const bool valid = session.update();
      if (valid && !asked) asked = session.power_on() == nullptr;
      for (int c = 0; c < kChannels; ++c) session.set_command(1, c, 33000.0);
      session.commit();
      if (valid && session.bus().feedback(1).channel[2].current == 33000) ++driven;
      link.wait(0.001);
    }
    EXPECT_EQ(driven, 50) << describe(session.state()) << "\n" << session.faults().report();
    EXPECT_EQ(session.shutdown(), OffState::kConfirmed);
  }
}

TEST_F(Served, AStoppedServerIsReportedAsMissingReplies) {
  UdpLink link("127.0.0.1", server_.port());
  SessionOptions options = Rig::options();
  BoardSession session(link, options);
  session.start();
  ASSERT_TRUE(session.update());
  stop_ = true;
  thread_.join();
  for (int k = 0; k < 3; ++k) EXPECT_FALSE(session.update());
  EXPECT_GE(session.faults().count(Condition::kNoReply), 3);
}

// From Rev 9 on the hub's board id is part of its address (section 2.3): 127.0.0.1 + 6 here.
TEST(Udp, ARev9HubIsFoundAtItsOwnAddress) {
  BoardEmulator emulator({Rig::setup(6, 9), Rig::setup(7, 9)});
  BoardServer server(emulator, 0);
  std::atomic<bool> stop{false};
  std::thread thread([&] { server.run(stop); });
  UdpLink link("127.0.0.1", server.port());
  BoardBus bus(link, Rig::options(CycleProtocol::kBroadcast).bus);
  bus.start();
  int valid = 0;
  for (int k = 0; k < 20; ++k) {
    valid += bus.read() ? 1 : 0;
    bus.write();
  }
  stop = true;
  thread.join();
  EXPECT_GE(valid, 18) << bus.faults().report();
  EXPECT_EQ(bus.faults().count(Condition::kForeignSender), 0);
}

int socket_at(const char* address, std::uint16_t port) {
  const int out = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_port = htons(port);
  ::inet_pton(AF_INET, address, &at.sin_addr);
  EXPECT_EQ(::bind(out, reinterpret_cast<const sockaddr*>(&at), sizeof at), 0) << address;
  return out;
}

// Boards have the server's address, and from Rev 9 on the hub has it plus its id. Whoever has
// another address of the same network, and the right port, is no board.
TEST(Udp, RepliesFromForeignAddressesAreIgnored) {
  const int board = socket_at("127.0.0.1", 0);
  sockaddr_in own{};
  socklen_t size = sizeof own;
  ::getsockname(board, reinterpret_cast<sockaddr*>(&own), &size);
  const std::uint16_t port = ntohs(own.sin_port);
  const int seventh = socket_at("127.0.0.7", port), other = socket_at("127.0.0.2", port);
  const int far = socket_at("127.0.1.7", port);
  for (const int firmware : {0, 8, 9}) {  // 0: the hub is not known yet
    UdpLink link("127.0.0.1", port);
    if (firmware > 0) link.set_hub(firmware, 6);
    std::uint8_t word[4] = {1, 2, 3, 4};
    ASSERT_TRUE(link.send({word, sizeof word}, Destination::kBoard));
    std::uint8_t bytes[64];
    sockaddr_in client{};
    size = sizeof client;
    const int asked = firmware == 9 ? seventh : board;
    ASSERT_EQ(::recvfrom(asked, bytes, sizeof bytes, 0, reinterpret_cast<sockaddr*>(&client), &size), 4);
    for (const auto& [from, known] :
         std::vector<std::pair<int, bool>>{{board, true},
                                           {seventh, firmware != 8},
                                           {other, firmware == 0},
                                           {far, false}}) {
      ::sendto(from, word, sizeof word, 0, reinterpret_cast<const sockaddr*>(&client), size);
      const Arrival came = link.receive({bytes, sizeof bytes}, 2.0);
      ASSERT_TRUE(came.any);
      EXPECT_EQ(came.known_source, known) << firmware;
    }
  }
  for (const int one : {board, seventh, other, far}) ::close(one);
}

// Programs of this machine alone may drive an emulated arm, unless the user allows others.
TEST(Udp, AnEmulatorListensToThisMachineAlone) {
  for (const auto listens : {BoardServer::Listens::kHere, BoardServer::Listens::kEverywhere}) {
    BoardEmulator emulator({Rig::setup(6)});
    BoardServer server(emulator, 0, listens);
    EXPECT_EQ(server.accepts_address(0x7F000001), true);
    EXPECT_EQ(server.accepts_address(0xC0A80105), listens == BoardServer::Listens::kEverywhere);
  }
}

TEST(Udp, InvalidAddressesAreRefused) {
  EXPECT_THROW(UdpLink("no such host", 1394), InvalidInput);
  BoardEmulator emulator({Rig::setup(6)});
  BoardServer server(emulator, 0);
  EXPECT_THROW(BoardServer(emulator, server.port()), InvalidInput);
  UdpLink link("127.0.0.1", server.port());
  EXPECT_EQ(link.address_word(), 0x0100007FU);  // section 5, #1
}

}  // namespace
}  // namespace veridyn::dvrk
