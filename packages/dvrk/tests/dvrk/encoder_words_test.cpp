#include "dvrk/protocol/encoder_words.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "dvrk/protocol/analog.hpp"

namespace veridyn::dvrk {
namespace {

// Words and their decoding by the laboratory's library (threshold 1): specification 11.2.
TEST(EncoderWords, DecodedMotionEqualsThatOfTheDvrkHostSoftware) {
  struct Case {
    std::uint32_t period, quarter1, quarter5, running;
    double velocity, predicted, acceleration;
  };
  const Case cases[] = {
      {0x4000C000, 0x60003000, 0x60003000, 0x40000064, 4000, 4000, 0},
      {0x0000C000, 0x20003000, 0x20003000, 0x00000064, -4000, -4000, 0},
      {0x40013880, 0x50004E20, 0x50005DC0, 0x40000FA0, 2457.6, 2691.657143, 261463.106494},
      {0x40013880, 0x50004E20, 0x50005DC0, 0x40009C40, 2457.6, 1228.8, 261463.106494},
      {0x6000C000, 0x60003000, 0x20003000, 0x40000064, 0, 0, 0},
      {0x8BFFFFFF, 0x83FFFFFF, 0x83FFFFFF, 0x83FFFFFF, 0, 0, 0},
      {0x48009C40, 0x60003000, 0x00000000, 0x40000010, 4915.2, 4915.2, 0}};
  for (const Case& c : cases) {
    const EncoderMotion motion =
        encoder_motion({0x800000, c.period, c.quarter1, c.quarter5, c.running}, 1.0);
    EXPECT_NEAR(motion.velocity, c.velocity, 1e-9) << std::hex << c.period;
    EXPECT_NEAR(motion.predicted, c.predicted, 1e-6) << std::hex << c.period << " " << c.running;
    EXPECT_NEAR(motion.acceleration, c.acceleration, 1e-6) << std::hex << c.period;
  }
}

// An encoder under constant acceleration, edge times computed here: the prediction is the true
// speed now, while the mean over the last period is late.
TEST(EncoderWords, PredictedVelocityIsExactUnderConstantAcceleration) {
  const double start = 3000.0, acceleration = 40000.0;  // counts/s, counts/s^2
  const auto edge_time = [&](int k) {                   // x(t) = k for v0 t + a t^2 / 2
    return (std::sqrt(start * start + 2.0 * acceleration * k) - start) / acceleration;
  };
  const auto ticks = [](double seconds) {
    return static_cast<std::uint32_t>(std::lround(seconds * kEncoderClock));
  };
  const double now = edge_time(9) + 0.4 * (edge_time(10) - edge_time(9));
  EncoderWords words;
  words.period = 0x40000000 | ticks(edge_time(9) - edge_time(5));
  words.quarter1 = 0x60000000 | ticks(edge_time(9) - edge_time(8));
  words.quarter5 = 0x60000000 | ticks(edge_time(5) - edge_time(4));
  words.running = 0x40000000 | ticks(now - edge_time(9));
  const double truth = start + acceleration * now;
  const EncoderMotion motion = encoder_motion(words, 1.0);
  EXPECT_NEAR(motion.acceleration, acceleration, 0.01 * acceleration);
  EXPECT_NEAR(motion.predicted, truth, 1e-4 * truth);
  EXPECT_GT(std::abs(motion.velocity - truth), 10 * std::abs(motion.predicted - truth));
}

TEST(EncoderWords, NoAccelerationFromQuartersShorterThanTheThreshold) {
  // 1/quarter1 = 1/20000 = 5e-5.
  const EncoderWords words{0x800000, 0x40013880, 0x50004E20, 0x50005DC0, 0x40000FA0};
  EXPECT_EQ(encoder_motion(words, 4e-5).acceleration, 0.0);
  EXPECT_NE(encoder_motion(words, 6e-5).acceleration, 0.0);
}

TEST(EncoderWords, CountsAndPreloadAreInverse) {
  EXPECT_EQ(preload_word(1000), 0x008003E8U);  // captured, specification 11.1
  EXPECT_EQ(encoder_counts(0x108003E8), 1000);
  EXPECT_EQ(encoder_counts(0x00000000), -0x800000);
  for (const std::int32_t counts : {-0x800000, -1, 0, 1, 123456, 0x7FFFFF})
    EXPECT_EQ(encoder_counts(preload_word(counts)), counts);
  EXPECT_EQ(encoder_counts(preload_word(1LL << 40)), 0x7FFFFF);
  EXPECT_EQ(encoder_counts(preload_word(-(1LL << 40))), -0x800000);
  EXPECT_TRUE(encoder_overflow(0x01800000));
  EXPECT_FALSE(encoder_overflow(0x70FFFFFF));
  EXPECT_TRUE(encoder_error(0x5000C000));
}

TEST(EncoderWords, TheWordsAtPowerUpDecodeToRestAtCountZero) {
  const EncoderMotion motion = encoder_motion(EncoderWords{});
  EXPECT_EQ(motion.velocity, 0.0);
  EXPECT_EQ(motion.predicted, 0.0);
  EXPECT_EQ(encoder_counts(EncoderWords{}.position), 0);
}

// Numbers of specification 12.
TEST(Analog, NominalConversionsHaveTheNumbersOfTheSpecification) {
  EXPECT_NEAR(kNominalAmpsToBits.scale, 5242.88, 1e-9);
  EXPECT_NEAR(kNominalAmpsToBits(1.0), 38010.88, 1e-9);
  EXPECT_NEAR(kNominalBitsToAmps(0x8000), 0.0, 1e-15);
  EXPECT_NEAR(kNominalBitsToAmps.scale, 1.9073486e-4, 1e-11);
  EXPECT_NEAR(kNominalBitsToVolts(65536), 4.5, 1e-15);
  EXPECT_EQ(temperature(0x32), 25.0);
  EXPECT_TRUE(std::isnan(temperature(0xFF)));
  EXPECT_EQ(nearest_word(32767.6, 7), 32768);
  EXPECT_EQ(nearest_word(-3.0, 7), 0);
  EXPECT_EQ(nearest_word(1e9, 7), 65535);
  EXPECT_EQ(nearest_word(std::nan(""), 7), 7);
}

}  // namespace
}  // namespace veridyn::dvrk
