#include "veridyn/control/load_cell.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <random>

#include "veridyn/math/require.hpp"

// Load cells: calibration, what comes over a line, and how a dead or stuck one is found.

namespace veridyn {
namespace {

int readings_of(LoadCellDecoder& decoder, const std::string& bytes, std::vector<double>& out) {
  int count = 0;
  for (const char c : bytes) {
    if (!decoder.take(static_cast<std::uint8_t>(c))) continue;
    out.push_back(decoder.raw());
    ++count;
  }
  return count;
}

std::string frame(std::uint16_t number, std::int32_t raw) {
  std::uint8_t bytes[10] = {0xA5, 0x5A};
  const auto word = static_cast<std::uint32_t>(raw);
  bytes[2] = static_cast<std::uint8_t>(number & 0xFF);
  bytes[3] = static_cast<std::uint8_t>(number >> 8);
  for (int k = 0; k < 4; ++k) bytes[4 + k] = static_cast<std::uint8_t>(word >> (8 * k));
  const std::uint16_t crc = crc16(bytes + 2, 6);
  bytes[8] = static_cast<std::uint8_t>(crc & 0xFF);
  bytes[9] = static_cast<std::uint8_t>(crc >> 8);
  return {reinterpret_cast<const char*>(bytes), sizeof(bytes)};
}

// The check value of this CRC over the digits 1 to 9, as its catalogue has it.
TEST(LoadCell, TheCrcIsTheOneThatItsNameSays) {
  EXPECT_EQ(crc16(reinterpret_cast<const std::uint8_t*>("123456789"), 9), 0x29B1);
}

TEST(LoadCell, TextLinesOfUsualConvertersAreRead) {
  LoadCellDecoder decoder(LoadCellFormat::kText);
  std::vector<double> got;
  readings_of(decoder, "cut 5\nHX711 reading: 8388607\r\n-12.5\n0.1,512\nHX711\n\x01\x02 7\n1e3\n", got);
  EXPECT_EQ(got, (std::vector<double>{8388607.0, -12.5, 512.0, 1000.0}));
  EXPECT_EQ(decoder.refused(), 2);  // a name without a number, bytes that are no text
}

// Tabs, names with an equals sign and blanks at the end belong to usual lines; what is too long, whole or
// in one field, or blank, is none.
TEST(LoadCell, LinesWithBlanksAndLinesThatAreTooLong) {
  LoadCellDecoder decoder(LoadCellFormat::kText);
  std::vector<double> got;
  readings_of(decoder, "cut\n1\t2\nF=3\nt=1 F=4 \t\n0.1, 5\n   \n0" + std::string(48, '0') + "6\n", got);
  EXPECT_EQ(got, (std::vector<double>{2.0, 3.0, 4.0, 5.0}));
  EXPECT_EQ(decoder.refused(), 2);
  readings_of(decoder, "7 " + std::string(100, ' ') + "8\n9\n", got);
  EXPECT_EQ(got.back(), 9.0);
  EXPECT_EQ(got.size(), 5U);
  EXPECT_EQ(decoder.refused(), 3);
}

// Two weights with one reading each leave nothing to tell an interval from.
TEST(LoadCell, WithoutRepetitionThereIsNoInterval) {
  const LoadCellCalibration found = calibrate_load_cell({0.0, 2.0}, {100.0, 300.0});
  EXPECT_NEAR(found.scale, 0.01, 1e-12);
  EXPECT_TRUE(std::isnan(found.scale_interval) && std::isnan(found.offset_interval));
  for (const double bad : {static_cast<double>(NAN), static_cast<double>(INFINITY)}) {
    EXPECT_THROW(calibrate_load_cell({0.0, bad}, {1.0, 2.0}), InvalidInput);
    EXPECT_THROW(calibrate_load_cell({0.0, 1.0}, {1.0, bad}), InvalidInput);
  }
}

// The number before "nan" is the time, and "ERR 12" is no force of 12 N.
TEST(LoadCell, ALineWhoseLastFieldIsNoFiniteNumberIsRefused) {
  const std::vector<std::string> none = {
      "1.234,nan", "1.234,inf",   "1.234,-inf", "nan",     "1.234,",  "1.234;NaN", "5.2 N", "5.2N",
      "ERR 12",    "overload 12", "1.234,ERR",  "1e999",   "0x1F",    "1.2.3",     "--4",   "1,two,3",
      "12 12nan",  "reading:",    "1.234,1e",   "= nan",   "ERR,5",   "x 1: y 2",
      "F\x01: 12", "F\xB5=12"};
  for (const std::string& line : none) {
    LoadCellDecoder decoder(LoadCellFormat::kText);
    std::vector<double> got;
    readings_of(decoder, "cut\n" + line + "\n", got);
    EXPECT_TRUE(got.empty()) << line << " gave " << got.front();
    EXPECT_EQ(decoder.refused(), 1) << line;
  }
  const std::vector<std::pair<std::string, double>> readings = {
      {"8388607", 8388607.0}, {"0.1,512", 512.0},  {"0.1; -512.5", -512.5}, {"1 2 3", 3.0},
      {"force = 4.5", 4.5},   {"F:-1e-3 ", -1e-3}, {"t: 0.5, F: 2", 2.0},   {"HX711 reading: 7", 7.0}};
  for (const auto& [line, value] : readings) {
    LoadCellDecoder decoder(LoadCellFormat::kText);
    std::vector<double> got;
    readings_of(decoder, "cut\n" + line + "\n", got);
    EXPECT_EQ(got, std::vector<double>{value}) << line;
  }
}

// Every frame but the ones that were damaged, whatever stands between them.
TEST(LoadCell, BinaryFramesSurviveGarbageAndCuts) {
  std::mt19937 random(7);
  LoadCellDecoder decoder(LoadCellFormat::kBinary);
  std::string line;
  std::vector<double> sent, got;
  for (int k = 0; k < 2000; ++k) {
    std::string bytes = frame(static_cast<std::uint16_t>(k), 1000 * k - 700000);
    if (k % 7 == 3) bytes[5] = static_cast<char>(bytes[5] ^ 0x10);  // a bit is wrong
    if (k % 7 == 5) bytes.resize(4);                                // the rest was lost
    if (k % 7 != 3 && k % 7 != 5) sent.push_back(1000.0 * k - 700000.0);
    if (k % 11 == 0) {
      for (int g = 0; g < 5; ++g) line += static_cast<char>(random() & 0x7F);
    }
    line += bytes;
  }
  readings_of(decoder, line, got);
  EXPECT_EQ(got, sent);
  EXPECT_GT(decoder.refused(), 200);
}

// raw = 100 + 50 f by hand: offset 100, scale 1/50; the interval holds the truth.
TEST(LoadCell, CalibrationFindsTheLineAndItsIntervals) {
  const LoadCellCalibration exact =
      calibrate_load_cell({0.0, 0.0, 10.0, 10.0}, {100.0, 100.0, 600.0, 600.0});
  EXPECT_NEAR(exact.offset, 100.0, 1e-9);
  EXPECT_NEAR(exact.scale, 0.02, 1e-12);
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 20.0);
  int covered = 0;
  for (int run = 0; run < 200; ++run) {
    std::vector<double> force, raw;
    for (const double f : {0.0, 4.9, 9.8, 19.6}) {
      for (int k = 0; k < 10; ++k) {
        force.push_back(f);
        raw.push_back(100.0 + 50.0 * f + noise(random));
      }
    }
    const LoadCellCalibration found = calibrate_load_cell(force, raw);
    covered += std::abs(found.scale - 0.02) <= found.scale_interval ? 1 : 0;
  }
  EXPECT_GT(covered, 178);  // 95 % of 200 less three standard deviations of the count
  EXPECT_LT(covered, 200);
  EXPECT_THROW(calibrate_load_cell({1.0, 1.0}, {5.0, 6.0}), InvalidInput);
  EXPECT_THROW(calibrate_load_cell({0.0, 1.0}, {5.0, 5.0}), InvalidInput);
}

// With two different forces the line passes through the mean reading of each, so that the offset is the mean of 99 and
// 101. The four residuals are 1, so a reading has the variance 4 / (4 - 2) = 2 and the mean of two of them half of it;
// Student's t for two degrees of freedom is 4.3027.
TEST(LoadCell, TheOffsetIsAsCertainAsTheReadingsWithoutForce) {
  const LoadCellCalibration found = calibrate_load_cell({0.0, 0.0, 10.0, 10.0}, {99.0, 101.0, 599.0, 601.0});
  EXPECT_NEAR(found.offset_interval, 4.3026527 * std::sqrt(2.0 / 2.0), 1e-6);
}

// A source that the test speaks through.
class Spoken final : public ForceSource {
 public:
  Spoken(int& fresh, double& raw, const double* lay = nullptr) : fresh_(fresh), raw_(raw), lay_(lay) {}
  int poll() noexcept override {
    const int count = fresh_;
    fresh_ = 0;
    return count;
  }
  double raw() const noexcept override { return raw_; }
  double lay() const noexcept override { return lay_ != nullptr ? *lay_ : 0.0; }

 private:
  int& fresh_;
  double& raw_;
  const double* lay_;
};

TEST(ForceChannel, ADeadOrStuckSensorIsFoundWithinTwentyMilliseconds) {
  for (const bool stuck : {false, true}) {
    int fresh = 0;
    double raw = 0.0;
    ForceChannel channel(std::make_unique<Spoken>(fresh, raw), {});
    std::mt19937 random(5);
    double found = -1.0;
    for (int k = 0; k < 1000 && found < 0.0; ++k) {  // a loop at 1 kHz, a cell at 500 Hz
      const double t = 1e-3 * k;
      const bool failed = k >= 500;
      if (k % 2 == 0 && !(failed && !stuck)) {
        fresh = 1;
        if (!failed) raw = 5.0 + 1e-3 * static_cast<double>(random() % 1000);
      }
      channel.update(t);
      if (!failed && k > 0) {
        ASSERT_EQ(channel.state(), ForceState::kGood) << t;
      }
      if (failed && channel.state() != ForceState::kGood) found = t - 0.5;
    }
    EXPECT_GT(found, 0.0);
    EXPECT_LE(found, 0.020) << (stuck ? "stuck" : "dead");
    EXPECT_EQ(channel.state(), stuck ? ForceState::kStuck : ForceState::kDead);
  }
}

// Bytes out of the middle of a stream of lines, as a bad cable loses them.
class Torn final : public ForceSource {
 public:
  explicit Torn(double lost) : lost_(lost), decoder_(LoadCellFormat::kText) {}
  int poll() noexcept override {
    const int count = fresh_ ? 1 : 0;
    fresh_ = false;
    return count;
  }
  void say(const std::string& line) {
    for (const char c : line) {
      const bool gone = std::uniform_real_distribution<double>()(random_) < lost_;
      if (!gone && decoder_.take(static_cast<std::uint8_t>(c))) fresh_ = true;
    }
  }
  double raw() const noexcept override { return decoder_.raw(); }
  long refused() const noexcept override { return decoder_.refused(); }

 private:
  double lost_;
  std::mt19937 random_{11};
  LoadCellDecoder decoder_;
  bool fresh_ = false;
};

TEST(ForceChannel, BytesThatAreLostGiveNoReadingBeyondTheRange) {
  for (const bool watched : {true, false}) {
    auto source = std::make_unique<Torn>(0.1);
    Torn& line = *source;
    ForceChannelOptions options;
    options.stuck_after = 0.0;
    if (!watched) {
      options.range = 1e300;
      options.largest_jump = 1e300;
    } else {
      options.largest_jump = 20.0;
    }
    ForceChannel channel(std::move(source), options);
    double largest = 0.0;
    bool noisy = false;
    for (int k = 0; k < 5000; ++k) {
      line.say("-12.3" + std::to_string(10 + k % 90) + "\n");
      const ForceReading reading = channel.update(1e-3 * k);
      if (reading.number >= 0) largest = std::max(largest, std::abs(reading.force));
      noisy = noisy || channel.state() == ForceState::kNoisy;
    }
    if (watched) {
      EXPECT_LT(largest, 200.0);
      EXPECT_TRUE(noisy);
      EXPECT_GT(channel.beyond_range(), 50);
      EXPECT_GT(channel.jumps(), 50);
    } else {
      EXPECT_GT(largest, 1e5);  // what the range and the watch over jumps keep away
    }
  }
}

// Whatever a converter gives: what is no number is beyond every range, and the filter forgets it.
TEST(ForceChannel, WhatIsNoNumberIsBeyondEveryRange) {
  int fresh = 0;
  double raw = 0.0;
  ForceChannelOptions options;
  options.range = std::numeric_limits<double>::infinity();
  options.cutoff = 30.0;
  options.latency = 0.002;
  ForceChannel channel(std::make_unique<Spoken>(fresh, raw), options);
  EXPECT_NEAR(channel.delay(), 0.002 + 1.0 / (2.0 * M_PI * 30.0), 1e-12);
  const double bad[] = {NAN, INFINITY, -INFINITY};
  for (int k = 0; k < 9; ++k) {  // the first three before anything else, the others one by one
    const bool good = k >= 3 && k % 2 == 0;
    raw = good ? 5.0 + 0.01 * k : bad[k % 3];
    fresh = 1;
    const ForceReading reading = channel.update(1e-3 * k);
    EXPECT_TRUE(std::isfinite(reading.force)) << k;
    EXPECT_EQ(channel.state() == ForceState::kRange, !good) << k;
    EXPECT_EQ(reading.number.has_value(), k >= 4) << k;
  }
  options.cutoff = 0.0;
  EXPECT_EQ(ForceChannel(std::make_unique<Spoken>(fresh, raw), options).delay(), 0.002);
}

// A source that never ends gets its share of a cycle and no more.
TEST(ForceChannel, ASourceThatNeverEndsDoesNotHoldTheLoop) {
  struct Flood final : ForceSource {
    int poll() noexcept override { return 1; }
    double raw() const noexcept override { return 5.0; }
  };
  ForceChannel channel(std::make_unique<Flood>(), {});
  EXPECT_EQ(channel.update(0.0).number, 255);
  EXPECT_EQ(channel.update(1e-3).number, 511);
}

TEST(ForceChannel, AJumpIsBelievedWhereTheNextReadingAgrees) {
  int fresh = 0;
  double raw = 0.0;
  ForceChannelOptions options;
  options.largest_jump = 5.0;
  options.stuck_after = 0.0;
  ForceChannel channel(std::make_unique<Spoken>(fresh, raw), options);
  std::vector<double> given;
  for (const double said : {1.0, 1.1, 90.0, 1.2, 30.0, 30.1, -120.0, 500.0, 30.2}) {
    raw = said;
    fresh = 1;
    given.push_back(channel.update(1e-3 * static_cast<double>(given.size())).force);
    EXPECT_EQ(channel.state() == ForceState::kRange, said > 200.0) << said;
  }
  EXPECT_EQ(given, (std::vector<double>{1.0, 1.1, 1.1, 1.2, 1.2, 30.1, 30.1, 30.1, 30.2}));
  EXPECT_EQ(channel.jumps(), 3);
  EXPECT_EQ(channel.beyond_range(), 1);
}

// One unusable reading in thirty is fewer than noisy_share, one in ten is more.
TEST(ForceChannel, IsNoisyByTheShareOfUnusableReadings) {
  for (const int one_in : {30, 10}) {
    int fresh = 0;
    double raw = 0.0;
    ForceChannelOptions options;
    options.largest_jump = 5.0;
    options.stuck_after = 0.0;
    ForceChannel channel(std::make_unique<Spoken>(fresh, raw), options);
    bool noisy = false;
    for (int k = 1; k <= 1000; ++k) {
      raw = k % one_in == 0 ? 90.0 : 1.0;
      fresh = 1;
      channel.update(1e-3 * k);
      noisy = noisy || channel.state() == ForceState::kNoisy;
    }
    EXPECT_EQ(noisy, one_in == 10) << one_in;
  }
}

// From the first look on: a line that never spoke is as old as the look.
TEST(ForceChannel, TheAgeOfASensorThatNeverSpokeCountsFromTheStart) {
  int fresh = 0;
  double raw = 0.0;
  ForceChannel channel(std::make_unique<Spoken>(fresh, raw), {});
  EXPECT_EQ(channel.update(7.0).age, 0.0);
  const ForceReading reading = channel.update(7.5);
  EXPECT_FALSE(reading.number);
  EXPECT_NEAR(reading.age, 0.5, 1e-12);
  EXPECT_EQ(channel.state(), ForceState::kWaiting);
}

// When the system's clock is set ahead between the arrival of a reading and its poll(), it seems to have lain for long.
TEST(ForceChannel, AReadingMakesItNoOlder) {
  int fresh = 0;
  double raw = 0.0, lay = 0.0;
  ForceChannel channel(std::make_unique<Spoken>(fresh, raw, &lay), {});
  fresh = 1;
  channel.update(1.0);
  const double without = channel.update(1.002).age;
  fresh = 1;
  raw = 0.1;
  lay = 0.5;
  EXPECT_EQ(channel.update(1.002).age, without);
  EXPECT_EQ(channel.state(), ForceState::kGood);
}

// However long a sensor has run, its reading may stay the same for as long as stuck_after.
TEST(ForceChannel, IsStuckNoEarlierThanAReadingHasStayedTheSame) {
  int fresh = 0;
  double raw = 0.0;
  ForceChannelOptions options;
  options.stuck_after = 0.05;
  options.stuck_readings = 3;
  ForceChannel channel(std::make_unique<Spoken>(fresh, raw), options);
  for (int k = 0; k < 1100; ++k) {
    raw = 0.01 * (std::min(k, 1000) % 2);
    fresh = 1;
    channel.update(1e-3 * k);
    if (std::abs(k - 1050) < 2) continue;
    EXPECT_EQ(channel.state(), k < 1050 ? ForceState::kGood : ForceState::kStuck) << k;
  }
}

// A ramp of one unit per second lags by the delays of the line and of the filter.
TEST(ForceChannel, ItsDelayIsTheOneThatItTells) {
  int fresh = 0;
  double raw = 0.0;
  ForceChannelOptions options;
  options.cutoff = 20.0;
  options.latency = 0.004;
  options.range = 1e9;
  ForceChannel channel(std::make_unique<Spoken>(fresh, raw), options);
  ForceReading reading;
  for (int k = 0; k < 2000; ++k) {
    raw = 1e-3 * k - options.latency;  // what the cell felt that long ago
    fresh = 1;
    reading = channel.update(1e-3 * k);
  }
  EXPECT_NEAR(raw + options.latency - reading.force, channel.delay(), 6e-4);  // half a sample of a hold
}

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
    forget_line();
  }
  void say(const std::string& bytes) const {
    ASSERT_EQ(::write(host_, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  }
  void unplug() {
    if (host_ >= 0) ::close(host_);
    host_ = -1;
  }
  // The channel has it open by itself.
  void forget_line() {
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

TEST(SerialLine, ReadingsNoiseAndAPulledPlug) {
  Terminal line;
  if (!line.exists()) GTEST_SKIP() << "no pseudo-terminal on this machine";
  const std::unique_ptr<ForceSource> source =
      open_force_source("serial:" + line.name() + ":115200:binary");
  line.forget_line();
  line.say(std::string("\x00\xffgarbage\xa5", 10) + frame(1, 42) + frame(2, -7).substr(0, 6));
  EXPECT_EQ(poll_for(*source), 1);
  EXPECT_EQ(source->raw(), 42.0);
  line.say(frame(3, 99));
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
TEST(SerialLine, DeadStuckAndPulledAreFoundWithin20Milliseconds) {
  enum class End { kSilent, kStuck, kPulled };
  for (const End end : {End::kSilent, End::kStuck, End::kPulled}) {
    Terminal line;
    if (!line.exists()) GTEST_SKIP() << "no pseudo-terminal on this machine";
    ForceChannel channel(open_force_source("serial:" + line.name() + ":115200:text"), {});
    line.forget_line();
    line.say("cut\n");  // a first line counts as cut
    double found = -1.0;
    for (int k = 0; k < 200 && found < 0.0; ++k) {
      const bool well = k < 100;
      if (k == 100 && end == End::kPulled) line.unplug();
      if (k % 2 == 0 && (well || end == End::kStuck))
        line.say("F: " + std::to_string(well ? k : 100) + "\n");
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

TEST(SerialLine, SaysWhatIsNoLine) {
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
  void say(const std::string& words) const {
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

TEST(Udp, DatagramsAreReadings) {
  const auto source = open_force_source("udp:47113:text");
  const Sender cell(47113);
  cell.say("512.5");
  cell.say("cell: 513\n");
  cell.say("1\n2\n3");
  EXPECT_EQ(poll_for(*source), 1);  // one at a time
  EXPECT_EQ(source->raw(), 512.5);
  EXPECT_EQ(poll_all(*source), 4);
  EXPECT_EQ(source->raw(), 3.0);
  for (const char* wrong : {"udp:x", "usb:1", "udp:0", "udp:1.2.3:5", "udp:127.0.0.1", "udp:127.0.0.1:5:6:7",
                            "udp:", "udp:-5", "udp:65536", "udp:5x"})
    EXPECT_THROW(open_force_source(wrong), InvalidInput) << wrong;
}

TEST(Udp, ThePortIsThisMachinesUnlessAnAddressIsGiven) {
  const auto source = open_force_source("udp:47114");
  Sender(47114, "127.0.0.2").say("5");
  EXPECT_EQ(poll_all(*source), 0);
  const auto other = open_force_source("udp:127.0.0.3:47114:text");
  Sender(47114, "127.0.0.3").say("6");
  EXPECT_EQ(poll_all(*source), 0);
  EXPECT_EQ(poll_for(*other), 1);
  const auto all = open_force_source("udp:0.0.0.0:47115");
  Sender(47115, "127.0.0.2").say("7");
  EXPECT_EQ(poll_for(*all), 1);
}

TEST(Udp, TheFirstSenderOwnsThePortUntilItIsSilent) {
  const auto source = open_force_source("udp:47116");
  const Sender cell(47116), stranger(47116);
  cell.say("1");
  stranger.say("99");
  EXPECT_EQ(poll_all(*source), 1);
  stranger.say("98");
  cell.say("2");
  stranger.say("97");
  EXPECT_EQ(poll_all(*source), 1);
  EXPECT_EQ(source->raw(), 2.0);
  ::usleep(1100000);  // the cell is gone
  EXPECT_EQ(source->poll(), 0);
  stranger.say("96");
  EXPECT_EQ(poll_for(*source), 1);
  EXPECT_EQ(source->raw(), 96.0);
  cell.say("3");
  EXPECT_EQ(poll_all(*source), 0);
}

// What lay in the socket while the program did not look is as old as it is.
// The kernel begins to stamp datagrams some time after the first socket wants it, and gives the time of reading until then:
// a channel that stays open waits for it.
TEST(Udp, TheAgeOfAReadingCountsFromItsArrival) {
  ForceChannel before(open_force_source("udp:47118"), {});
  const Sender early(47118);
  double age = 0.0;
  for (int k = 0; k < 1000 && age < 0.002; ++k) {
    early.say("0");
    ::usleep(3000);
    age = before.update(1e-3 * k).age;
  }
  ForceChannel channel(open_force_source("udp:47117"), {});
  const Sender cell(47117);
  cell.say("1");
  cell.say("2");
  ::usleep(50000);
  const ForceReading reading = channel.update(10.0);
  EXPECT_EQ(reading.number, 1);
  EXPECT_EQ(reading.raw, 2.0);
  EXPECT_GE(reading.age, 0.045);
  EXPECT_EQ(channel.state(), ForceState::kDead);
}

}  // namespace
}  // namespace veridyn
