#include <gtest/gtest.h>

#include <cmath>

#include "emulator/emulated_encoder.hpp"

namespace veridyn::dvrk {
namespace {

constexpr double kClock = 49.152e6;

// Moves with x(t) in steps of 0.1 ms.
template <typename Position>
void follow(EmulatedEncoder& encoder, double from, double until, Position x) {
  for (double t = from; t < until - 1e-9; t += 1e-4)
    encoder.move(x(t + 1e-4), static_cast<Ticks>((t + 1e-4) * kClock));
}

// Change of a velocity by one tick in the time of four edges [counts/s].
double one_tick(double speed) {
  return 1.01 * speed * speed / (4.0 * kClock) + 1e-9;
}

TEST(EmulatedEncoder, CountAndVelocityAreDecodedFromItsWords) {
  for (const double speed : {12.0, 431.0, 52000.0, -77.0, -250000.0}) {
    EmulatedEncoder encoder;
    encoder.power_up(0.5, 0);
    follow(encoder, 0.0, 1.0, [&](double t) { return 0.5 + speed * t; });
    const EncoderWords w = encoder.words(8, static_cast<Ticks>(kClock));
    EXPECT_EQ(encoder_counts(w.position), static_cast<int>(std::floor(0.5 + speed))) << speed;
    EXPECT_NEAR(encoder_motion(w).velocity, speed, one_tick(speed)) << speed;
    EXPECT_FALSE(encoder_overflow(w.position) || encoder_error(w.period));
    const EncoderWords old = encoder.words(6, static_cast<Ticks>(kClock));
    // Four counts in a period of the slower clock.
    EXPECT_NEAR(4.0 * 3.072e6 / (old.period & 0x3FFFFF), std::abs(speed), 0.02 * std::abs(speed)) << speed;
  }
}

TEST(EmulatedEncoder, AccelerationIsDecodedFromItsWords) {
  EmulatedEncoder encoder;
  encoder.power_up(0.0, 0);
  const double a = 4000.0;
  follow(encoder, 0.0, 0.5, [&](double t) { return 0.5 * a * t * t; });
  const EncoderMotion m = encoder_motion(encoder.words(8, static_cast<Ticks>(0.5 * kClock)));
  EXPECT_NEAR(m.acceleration, a, 0.15 * a);
  EXPECT_NEAR(m.predicted, a * 0.5, 0.01 * a * 0.5);
}

TEST(EmulatedEncoder, VelocityIsZeroAfterAReversalAndAtRest) {
  EmulatedEncoder encoder;
  encoder.power_up(0.5, 0);
  EXPECT_EQ(encoder.words(8, 10).period, 0xCBFFFFFFU);  // section 11.2, power-up
  EXPECT_EQ(encoder.words(8, 10).running, 0x83FFFFFFU);
  follow(encoder, 0.0, 0.1, [](double t) { return 0.5 + 1000.0 * t; });
  follow(encoder, 0.1, 0.1015, [](double t) { return 100.5 - 1000.0 * (t - 0.1); });
  EncoderWords w = encoder.words(8, static_cast<Ticks>(0.1015 * kClock));
  EXPECT_NE(w.period & (1U << 29), 0U);
  EXPECT_EQ(encoder_motion(w).velocity, 0.0);
  w = encoder.words(8, static_cast<Ticks>(1.6 * kClock));  // 26 bits are 1.37 s
  EXPECT_EQ(w.running & 0x83FFFFFFU, 0x83FFFFFFU);
  EXPECT_EQ(encoder_motion(w).predicted, 0.0);
}

TEST(EmulatedEncoder, APreloadSetsTheCountAndNotTheEncoderLines) {
  EmulatedEncoder encoder;
  encoder.power_up(17.0, 0);
  const bool a = encoder.line_a();
  EXPECT_EQ(encoder_counts(encoder.words(8, 1).position), 0);
  encoder.preload(preload_word(-4321));
  EXPECT_EQ(encoder_counts(encoder.words(8, 1).position), -4321);
  EXPECT_EQ(encoder.line_a(), a);
  encoder.move(27.0, 100);
  EXPECT_EQ(encoder_counts(encoder.words(8, 100).position), -4311);
  EXPECT_FALSE(encoder.overflow_latched);
  encoder.move(-9.0e6, 200);
  EXPECT_TRUE(encoder_overflow(encoder.words(8, 200).position));
}

// The kinds of four edges in a row, in the order that the lines have them.
TEST(EmulatedEncoder, EdgesAreClassifiedByTypeAndDirection) {
  EmulatedEncoder encoder;
  encoder.power_up(0.5, 0);
  EXPECT_TRUE(encoder.line_a());
  const std::uint32_t up[] = {4, 2, 1, 8};
  for (int k = 0; k < 4; ++k) {
    encoder.move(1.5 + k, 1000 * (k + 1));
    EXPECT_EQ((encoder.words(8, 4000).quarter1 >> 26) & 0xF, up[k]);
  }
  EXPECT_TRUE(encoder.line_a());
  const std::uint32_t down[] = {2, 4, 8, 1};  // the same edges the other way round
  for (int k = 0; k < 4; ++k) {
    encoder.move(3.5 - k, 1000 * (k + 5));
    EXPECT_EQ((encoder.words(8, 9000).quarter1 >> 26) & 0xF, down[k]);
  }
}

}  // namespace
}  // namespace veridyn::dvrk
