#include "veridyn/simulation/force_sensor.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

// The force equals the time, so that each sample shows its own time.
TEST(ForceSensor, EverySampleHasTheValueOfItsRateAndDelay) {
  for (const double delay : {0.0, 0.003, 0.005}) {
    ForceSensorOptions options;
    options.rate = 500.0;
    options.delay = delay;
    ForceSensor sensor(options);
    for (int k = 0; k < 100; ++k) {
      const double t = 1e-3 * k;
      const ForceSample s = sensor.read(t, t);
      const double newest = std::floor((t - delay) * 500.0 + 1e-6) / 500.0;
      if (newest < 0.0) {
        EXPECT_FALSE(s.number);
      } else {
        EXPECT_NEAR(s.force, newest, 1e-12) << t;
        EXPECT_NEAR(s.time, newest, 1e-12);
        EXPECT_EQ(s.number, std::lround(newest * 500.0));
      }
    }
  }
}

TEST(ForceSensor, ASlowerLoopGetsANewReadingInEveryCall) {
  ForceSensorOptions options;
  options.rate = 500.0;
  ForceSensor sensor(options);
  for (int k = 0; k < 50; ++k) EXPECT_EQ(sensor.read(0.0025 * k, 0.0025 * k).force, 0.0025 * k);
}

TEST(ForceSensor, NoiseHasTheGivenDeviationAndZeroMean) {
  ForceSensorOptions options;
  options.noise = 0.05;
  options.rate = 1000.0;
  ForceSensor sensor(options);
  double sum = 0.0;
  double squares = 0.0;
  for (int k = 0; k < 20000; ++k) {
    const double e = sensor.read(1e-3 * k, 3.0).force - 3.0;
    sum += e;
    squares += e * e;
  }
  EXPECT_NEAR(sum / 20000, 0.0, 4.0 * 0.05 / std::sqrt(20000.0));
  EXPECT_NEAR(std::sqrt(squares / 20000), 0.05, 0.002);
}

TEST(ForceSensor, AStuckSensorSendsReadingsAndAStaleOneDoesNot) {
  ForceSensorOptions options;
  options.stuck_from = 0.05;
  ForceSensor stuck(options);
  options.stuck_from = INFINITY;
  options.stale_from = 0.05;
  ForceSensor stale(options);
  ForceSample a;
  ForceSample b;
  for (int k = 0; k < 100; ++k) {
    a = stuck.read(1e-3 * k, 1e-3 * k);
    b = stale.read(1e-3 * k, 1e-3 * k);
  }
  EXPECT_NEAR(a.force, 0.048, 1e-12);
  EXPECT_NEAR(a.time, 0.098, 1e-12);
  EXPECT_NEAR(b.force, 0.048, 1e-12);
  EXPECT_NEAR(b.time, 0.048, 1e-12);
}

TEST(ForceSensor, RejectsInvalidOptions) {
  ForceSensorOptions options;
  options.rate = 0.0;
  EXPECT_THROW(ForceSensor{options}, InvalidInput);
  options.rate = 500.0;
  for (const double delay : {-1e-3, 2001.0, 1e305}) {
    options.delay = delay;
    EXPECT_THROW(ForceSensor{options}, InvalidInput) << delay;
  }
  options.delay = 1.0;
  EXPECT_NO_THROW(ForceSensor{options});
  EXPECT_THROW(ForceSensor(options, 1e305), InvalidInput);
}

}  // namespace
}  // namespace veridyn
