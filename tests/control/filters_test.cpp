#include <gtest/gtest.h>

#include <cmath>

#include "support/near.hpp"
#include "veridyn/control/velocity_observer.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

VectorXd one(double value) {
  return VectorXd::Constant(1, value);
}

// On a ramp the velocity is exact in the end; on a parabola late by 2 / bandwidth without the
// acceleration, and not at all with it.
TEST(VelocityObserver, LagsByTwoOverItsBandwidthUnlessGivenTheAcceleration) {
  const double bandwidth = 200.0;
  VelocityObserver blind(1, bandwidth);
  VelocityObserver told(1, bandwidth);
  double t = 0.0;
  for (int k = 0; k < 2000; ++k) {
    const double dt = k % 3 == 0 ? 5e-4 : 1e-3;  // cycles of any length
    t += dt;
    blind.update(one(0.3 * t), one(0.0), dt);
  }
  EXPECT_NEAR(blind.dq()[0], 0.3, 1e-9);
  blind.reset();
  const double a = 2.0;
  for (int k = 0; k < 2000; ++k) {
    t = 1e-4 * k;
    blind.update(one(0.5 * a * t * t), one(0.0), 1e-4);
    told.update(one(0.5 * a * t * t), one(a), 1e-4);
  }
  EXPECT_NEAR(a * t - blind.dq()[0], a * 2.0 / bandwidth, 0.03 * a * 2.0 / bandwidth);
  EXPECT_NEAR(told.dq()[0], a * t, 1e-3 * a * t);
}

TEST(VelocityObserver, EncoderStepsAreSmoothedAndLostSamplesIgnored) {
  const double step = 1e-5;
  VelocityObserver observer(1);
  double worst = 0.0;
  for (int k = 0; k < 3000; ++k) {
    const double q = 0.01 * 1e-3 * k;
    const bool lost = k % 50 == 7;
    observer.update(one(lost ? NAN : std::round(q / step) * step), one(0.0), 1e-3);
    if (k > 300) worst = std::max(worst, std::abs(observer.dq()[0] - 0.01));
  }
  EXPECT_LT(worst, 300.0 * 300.0 * 1e-3 * step);  // of the documentation; differences give 10 mm/s
  EXPECT_GT(worst, 0.0);
  EXPECT_THROW(VelocityObserver(1, 0.0), InvalidInput);
}

}  // namespace
}  // namespace veridyn
