#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>
#include <set>
#include <string>

#include "veridyn/control/load_cell.hpp"

// How a channel distinguishes a force from a dead, stuck, noisy or saturated sensor.

namespace veridyn {
namespace {

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
  double queue_delay() const noexcept override { return lay_ != nullptr ? *lay_ : 0.0; }

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
  void write_line(const std::string& line) {
    for (const char c : line) {
      const bool gone = std::uniform_real_distribution<double>()(random_) < lost_;
      if (!gone && decoder_.add_byte(static_cast<std::uint8_t>(c))) fresh_ = true;
    }
  }
  double raw() const noexcept override { return decoder_.raw(); }
  long rejected_readings() const noexcept override { return decoder_.rejected_readings(); }

 private:
  double lost_;
  std::mt19937 random_{11};
  LoadCellDecoder decoder_;
  bool fresh_ = false;
};

TEST(ForceChannel, ReadingsTornByLostBytesAreRejectedByRangeAndJump) {
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
      line.write_line("-12.3" + std::to_string(10 + k % 90) + "\n");
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
      EXPECT_GT(largest, 1e5);  // without the checks of range and jumps it would be used
    }
  }
}

// Non-finite readings are beyond every range, and the filter drops them.
TEST(ForceChannel, NonFiniteReadingsAreBeyondEveryRange) {
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
TEST(ForceChannel, AnEndlessSourceDoesNotBlockTheLoop) {
  struct Flood final : ForceSource {
    int poll() noexcept override { return 1; }
    double raw() const noexcept override { return 5.0; }
  };
  ForceChannel channel(std::make_unique<Flood>(), {});
  EXPECT_EQ(channel.update(0.0).number, 255);
  EXPECT_EQ(channel.update(1e-3).number, 511);
}

TEST(ForceChannel, AJumpIsAcceptedIfTheNextReadingAgrees) {
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
TEST(ForceChannel, IsNoisyIfTheShareOfUnusableReadingsExceedsItsLimit) {
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

// The age of a line without readings counts from the first poll.
TEST(ForceChannel, TheAgeOfASensorWithoutReadingsCountsFromTheStart) {
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
TEST(ForceChannel, AReadingNeverIncreasesTheAge) {
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
TEST(ForceChannel, IsStuckOnlyAfterUnchangedReadings) {
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
TEST(ForceChannel, TheReportedDelayIsTheActualDelay) {
  int fresh = 0;
  double raw = 0.0;
  ForceChannelOptions options;
  options.cutoff = 20.0;
  options.latency = 0.004;
  options.range = 1e9;
  ForceChannel channel(std::make_unique<Spoken>(fresh, raw), options);
  ForceReading reading;
  for (int k = 0; k < 2000; ++k) {
    raw = 1e-3 * k - options.latency;  // the force one latency ago
    fresh = 1;
    reading = channel.update(1e-3 * k);
  }
  EXPECT_NEAR(raw + options.latency - reading.force, channel.delay(), 6e-4);  // half a sample of a hold
}

TEST(ForceChannel, EveryStateHasADescriptionOfItsOwn) {
  std::set<std::string> words;
  for (int k = 0; k <= static_cast<int>(ForceState::kNoisy); ++k) {
    EXPECT_TRUE(words.insert(describe(static_cast<ForceState>(k))).second) << k;
  }
  EXPECT_EQ(words.count(""), 0U);
}

}  // namespace
}  // namespace veridyn
