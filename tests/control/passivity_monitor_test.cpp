#include "veridyn/control/passivity_monitor.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace veridyn {
namespace {

constexpr double kStep = 1e-4;

// Force and rate of a spring of 1000 N/m on which the arms swing about their point of rest,
// x(t) = a e^(growth t) cos(40 t), with damping in the spring.
double generated(double growth, double damping) {
  PassivityMonitor monitor;
  const double a = 1e-3;
  for (double t = 0.0; t < 3.0; t += kStep) {
    const double size = a * std::exp(growth * t);
    const double x = size * std::cos(40.0 * t);
    const double v = size * (growth * std::cos(40.0 * t) - 40.0 * std::sin(40.0 * t));
    monitor.update(1000.0 * x + damping * v, v, kStep);
  }
  return monitor.generated();
}

// Over one quarter of a swing a spring gives back at most what it holds: 1/2 K a^2 = 0.5 mJ.
TEST(PassivityMonitor, ADecayingOscillationReturnsNoMoreThanTheStoredEnergy) {
  EXPECT_LT(generated(-2.0, 0.0), 0.51e-3);
  EXPECT_LT(generated(-20.0, 0.0), 0.2e-3);
}

// A limit cycle feeds the damping for ever: 1/2 c a^2 w^2 t.
TEST(PassivityMonitor, ALimitCycleGeneratesEnergyWithoutLimit) {
  EXPECT_NEAR(generated(0.0, 2.0), 0.5 * 2.0 * 1e-6 * 1600.0 * 3.0, 0.6e-3);
  EXPECT_GT(generated(1.0, 0.0), 5e-3);
}

TEST(PassivityMonitor, GeneratedEnergyIsZeroAtRestAndAfterAReset) {
  PassivityMonitor monitor;
  monitor.update(1.0, 0.0, kStep);
  EXPECT_EQ(monitor.generated(), 0.0);
  monitor.update(1.0, -1.0, kStep);
  EXPECT_EQ(monitor.generated(), 0.0);
  monitor.update(1.0, 3.0, kStep);
  EXPECT_DOUBLE_EQ(monitor.generated(), 3e-4);
  EXPECT_DOUBLE_EQ(monitor.energy(), 2e-4);
  monitor.reset();
  EXPECT_EQ(monitor.energy(), 0.0);
}

}  // namespace
}  // namespace veridyn
