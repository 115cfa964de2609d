#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <cmath>
#include <memory>
#include <string>

#include "control/load_cell_frame.hpp"
#include "veridyn/math/require.hpp"

// Load cells on a serial line and on a socket.

namespace veridyn {
namespace {

// A pseudo-terminal in the place of a serial line.
class Terminal {
 public:
  Terminal() : host_(::posix_openpt(O_RDWR | O_NOCTTY)) {
    ::grantpt(host_);
    ::unlockpt(host_);
    char name[128] = {};
    ::ptsname_r(host_, name, sizeof(name));
    name_ = name;
    // Without the file system of terminals, as in some containers, by the descriptor itself.
    if (::access(name, R_OK) != 0) {
      line_ = ::ioctl(host_, TIOCGPTPEER, O_RDWR | O_NOCTTY);
      name_ = "/proc/self/fd/" + std::to_string(line_);
    }
    termios raw{};
    ::tcgetattr(host_, &raw);
    ::cfmakeraw(&raw);
    ::tcsetattr(host_, TCSANOW, &raw);
  }
  ~Terminal() {
    unplug();
    release_line();
  }
  void write_bytes(const std::string& bytes) const {
    ASSERT_EQ(::write(host_, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  }
  void unplug() {
    if (host_ >= 0) ::close(host_);
    host_ = -1;
  }
  // The channel has it open by itself.
  void release_line() {
    if (line_ >= 0) ::close(line_);
    line_ = -1;
  }
  const std::string& name() const { return name_; }

  /// False where the machine has no pseudo-terminals, as in a root without /dev/pts.
  bool exists() const { return host_ >= 0 && ::access(name_.c_str(), R_OK) == 0; }

 private:
  int host_;
  int line_ = -1;
  std::string name_;
};

int poll_for(ForceSource& source) {
  int count = 0;
  for (int k = 0; k < 100 && count == 0; ++k) {
    count = source.poll();
    ::usleep(1000);
  }
  return count;
}

TEST(SerialLine, FramesBetweenGarbageAreReadAndAnUnpluggedDeviceIsDetected) {
  Terminal line;
  if (!line.exists()) GTEST_SKIP() << "no pseudo-terminal on this machine";
  const std::unique_ptr<ForceSource> source =
      open_force_source("serial:" + line.name() + ":115200:binary");
  line.release_line();
  line.write_bytes(std::string("\x00\xffgarbage\xa5", 10) + frame(1, 42) + frame(2, -7).substr(0, 6));
  EXPECT_EQ(poll_for(*source), 1);
  EXPECT_EQ(source->raw(), 42.0);
  line.write_bytes(frame(3, 99));
  EXPECT_EQ(poll_for(*source), 1);
  EXPECT_EQ(source->raw(), 99.0);
  EXPECT_TRUE(source->connected());
  EXPECT_EQ(source->poll(), 0);
  EXPECT_TRUE(source->connected());
  line.unplug();
  EXPECT_EQ(source->poll(), 0);
  EXPECT_FALSE(source->connected());
}

// Through a line, by the clock of a loop of 1 kHz: a cell that falls silent, one that repeats
// itself and a plug that is pulled are found within 20 ms.
TEST(SerialLine, ASilentStuckOrUnpluggedCellIsDetectedWithin20Milliseconds) {
  enum class End { kSilent, kStuck, kPulled };
  for (const End end : {End::kSilent, End::kStuck, End::kPulled}) {
    Terminal line;
    if (!line.exists()) GTEST_SKIP() << "no pseudo-terminal on this machine";
    ForceChannel channel(open_force_source("serial:" + line.name() + ":115200:text"), {});
    line.release_line();
    line.write_bytes("cut\n");  // the first line may be incomplete and is skipped
    double found = -1.0;
    for (int k = 0; k < 200 && found < 0.0; ++k) {
      const bool well = k < 100;
      if (k == 100 && end == End::kPulled) line.unplug();
      if (k % 2 == 0 && (well || end == End::kStuck))
        line.write_bytes("F: " + std::to_string(well ? k : 100) + "\n");
      channel.update(1e-3 * k);
      if (!well && channel.state() != ForceState::kGood) found = 1e-3 * (k - 100);
      if (well && k > 5) {
        EXPECT_EQ(channel.state(), ForceState::kGood) << k;
      }
    }
    EXPECT_GE(found, 0.0);
    EXPECT_LE(found, 0.020);
    EXPECT_EQ(channel.state(), end == End::kStuck ? ForceState::kStuck : ForceState::kDead);
  }
}

TEST(SerialLine, RejectsDevicesThatAreNotSerialLines) {
  EXPECT_THROW(open_force_source("serial:/dev/no-such-line"), InvalidInput);
  EXPECT_THROW(open_force_source("serial:/dev/null"), InvalidInput);
  EXPECT_THROW(open_force_source("serial:/dev/null:12345"), InvalidInput);
}

// Somebody who sends datagrams to a port of this machine.
class Sender {
 public:
  explicit Sender(int port, const char* address = "127.0.0.1") : socket_(::socket(AF_INET, SOCK_DGRAM, 0)) {
    at_.sin_family = AF_INET;
    at_.sin_port = htons(static_cast<std::uint16_t>(port));
    ::inet_pton(AF_INET, address, &at_.sin_addr);
  }
  ~Sender() { ::close(socket_); }
  void write_bytes(const std::string& words) const {
    ::sendto(socket_, words.data(), words.size(), 0, reinterpret_cast<const sockaddr*>(&at_), sizeof(at_));
  }

 private:
  int socket_;
  sockaddr_in at_{};
};

int poll_all(ForceSource& source) {
  int all = 0;
  for (int k = 0; k < 20; ++k) {
    while (source.poll() > 0) ++all;
    ::usleep(1000);
  }
  return all;
}

TEST(Udp, EveryLineOfADatagramIsAReading) {
  const auto source = open_force_source("udp:47113:text");
  const Sender cell(47113);
  cell.write_bytes("512.5");
  cell.write_bytes("cell: 513\n");
  cell.write_bytes("1\n2\n3");
  EXPECT_EQ(poll_for(*source), 1);  // one at a time
  EXPECT_EQ(source->raw(), 512.5);
  EXPECT_EQ(poll_all(*source), 4);
  EXPECT_EQ(source->raw(), 3.0);
  for (const char* wrong : {"udp:x", "usb:1", "udp:0", "udp:1.2.3:5", "udp:127.0.0.1", "udp:127.0.0.1:5:6:7",
                            "udp:", "udp:-5", "udp:65536", "udp:5x"})
    EXPECT_THROW(open_force_source(wrong), InvalidInput) << wrong;
}

TEST(Udp, ListensToThisMachineUnlessAnAddressIsGiven) {
  const auto source = open_force_source("udp:47114");
  Sender(47114, "127.0.0.2").write_bytes("5");
  EXPECT_EQ(poll_all(*source), 0);
  const auto other = open_force_source("udp:127.0.0.3:47114:text");
  Sender(47114, "127.0.0.3").write_bytes("6");
  EXPECT_EQ(poll_all(*source), 0);
  EXPECT_EQ(poll_for(*other), 1);
  const auto all = open_force_source("udp:0.0.0.0:47115");
  Sender(47115, "127.0.0.2").write_bytes("7");
  EXPECT_EQ(poll_for(*all), 1);
}

TEST(Udp, OnlyTheFirstSenderIsAcceptedUntilItIsSilentForASecond) {
  const auto source = open_force_source("udp:47116");
  const Sender cell(47116), stranger(47116);
  cell.write_bytes("1");
  stranger.write_bytes("99");
  EXPECT_EQ(poll_all(*source), 1);
  stranger.write_bytes("98");
  cell.write_bytes("2");
  stranger.write_bytes("97");
  EXPECT_EQ(poll_all(*source), 1);
  EXPECT_EQ(source->raw(), 2.0);
  ::usleep(1100000);  // the cell is gone
  EXPECT_EQ(source->poll(), 0);
  stranger.write_bytes("96");
  EXPECT_EQ(poll_for(*source), 1);
  EXPECT_EQ(source->raw(), 96.0);
  cell.write_bytes("3");
  EXPECT_EQ(poll_all(*source), 0);
}

// Datagrams that waited in the socket keep their age of arrival.
// The kernel begins to stamp datagrams some time after the first socket wants it, and gives the time of reading until then:
// a channel that stays open waits for it.
TEST(Udp, TheAgeOfAReadingCountsFromItsArrival) {
  ForceChannel before(open_force_source("udp:47118"), {});
  const Sender early(47118);
  double age = 0.0;
  for (int k = 0; k < 1000 && age < 0.002; ++k) {
    early.write_bytes("0");
    ::usleep(3000);
    age = before.update(1e-3 * k).age;
  }
  ForceChannel channel(open_force_source("udp:47117"), {});
  const Sender cell(47117);
  cell.write_bytes("1");
  cell.write_bytes("2");
  ::usleep(50000);
  const ForceReading reading = channel.update(10.0);
  EXPECT_EQ(reading.number, 1);
  EXPECT_EQ(reading.raw, 2.0);
  EXPECT_GE(reading.age, 0.045);
  EXPECT_EQ(channel.state(), ForceState::kDead);
}

}  // namespace
}  // namespace veridyn
