#include "veridyn/control/force_law.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr double kCycle = 1e-3;

// What the thesis saw: a step of 0.49 N cannot come to rest in a deadband 0.4 N wide.
TEST(ForceTracker, OscillatesAcrossADeadbandNarrowerThanOneStep) {
  for (const double deadband : {0.2, 0.4}) {
    ForceLaw law;
    law.kind = ForceLaw::Kind::kIncrement;
    law.increment = 0.0002;
    law.deadband = deadband;
    ForceTracker tracker(law);
    double x = 0.0;
    int changes = 0;
    for (int k = 0; k < 500; ++k) {
      const double before = x;
      x = tracker.update(5.0, {2450.0 * before - 0.12, 0.0, k}, 0.0, 0.002);
      if (k > 250) changes += x != before ? 1 : 0;
    }
    EXPECT_EQ(changes > 0, deadband < 0.245) << deadband;
  }
}

TEST(ForceTracker, TheIntegralDoesNotDependOnTheSensorRateAndIsBounded) {
  ForceLaw law;
  law.gain = 0.1;
  law.reach = 0.004;
  ForceTracker fast(law);
  ForceTracker slow(law);
  double a = 0.0;
  double b = 0.0;
  for (int k = 0; k < 9; ++k) {
    a = fast.update(2.0, {0.0, 0.0, k}, 0.0, kCycle);
    b = slow.update(2.0, {0.0, 0.0, k / 2}, 0.0, kCycle);
  }
  EXPECT_NEAR(a, 9 * 0.2 * kCycle, 1e-12);
  EXPECT_NEAR(b, a, 1e-12);
  for (int k = 9; k < 1000; ++k) a = fast.update(2.0, {0.0, 0.0, k}, 0.0, kCycle);
  EXPECT_EQ(a, 0.004);
}

TEST(ForceTracker, TheDampingTermIsMinusDampingTimesTheLengthRate) {
  ForceLaw law;
  law.damping = 0.4;
  ForceTracker tracker(law);
  EXPECT_DOUBLE_EQ(tracker.update(5.0, {5.0, 0.0, 1}, 0.01, kCycle), -0.004);
}

// x_f = integral + feed_forward h_d - damping dl/dt + proportional e, each with its sign; held
// targets keep the first three.
TEST(ForceTracker, TheCorrectionIsTheSumOfItsFourTerms) {
  ForceLaw law;
  law.gain = 0.1;
  law.proportional = 0.002;
  law.damping = 0.4;
  law.feed_forward = 0.003;
  ForceTracker tracker(law);
  const double integral = 0.1 * 2.0 * kCycle;
  EXPECT_DOUBLE_EQ(tracker.update(5.0, {3.0, 0.0, 1}, 0.01, kCycle),
                   integral + 0.015 - 0.004 + 0.004);
  EXPECT_DOUBLE_EQ(tracker.velocity(), 0.1 * 2.0);
  EXPECT_DOUBLE_EQ(tracker.update_without_sensor(-5.0, 0.01), integral - 0.015 - 0.004);
  EXPECT_EQ(tracker.velocity(), 0.0);
}

// The gains that tuned_force_law() promises: crossover, damping within bounds, zero on the pole.
TEST(TunedForceLaw, HasTheDesignedBandwidthForTheStiffness) {
  for (const double K : {200.0, 2450.0, 50000.0}) {
    const ForceLaw law = tuned_force_law(K, 300.0, 30.0);
    EXPECT_DOUBLE_EQ(law.gain * 300.0, 30.0);
    const double damping = law.damping * 300.0;
    EXPECT_LE(damping, 120.0);
    EXPECT_LE(damping, 2.0 * std::sqrt(1.4 * K) + 1e-9);
    EXPECT_DOUBLE_EQ(law.proportional / law.gain, (damping + 30.0) / K);
    EXPECT_DOUBLE_EQ(law.feed_forward, 1.0 / 300.0);
    EXPECT_GT(law.reach, 10.0 * (1.0 / 300.0 + 1.0 / K));
  }
  EXPECT_THROW(tuned_force_law(0.0, 300.0, 30.0), InvalidInput);
}

TEST(ForceTracker, RejectsInvalidGains) {
  ForceLaw law;
  law.gain = -1.0;
  EXPECT_THROW(ForceTracker{law}, InvalidInput);
  law.gain = NAN;
  EXPECT_THROW(ForceTracker{law}, InvalidInput);
}

}  // namespace
}  // namespace veridyn
