#include "veridyn/simulation/resampled_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/near.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

// q = t^5 - 2 t^2 in the first joint and 3 - t^3 in the second.
MotionSamples polynomials(const VectorXd& time) {
  const auto n = time.size();
  MotionSamples m{time, MatrixXd(n, 2), MatrixXd(n, 2), MatrixXd(n, 2)};
  const Eigen::ArrayXd t = time.array();
  m.q.col(0) = t.pow(5) - 2.0 * t.square();
  m.dq.col(0) = 5.0 * t.pow(4) - 4.0 * t;
  m.ddq.col(0) = 20.0 * t.pow(3) - 4.0;
  m.q.col(1) = 3.0 - t.pow(3);
  m.dq.col(1) = -3.0 * t.square();
  m.ddq.col(1) = -6.0 * t;
  return m;
}

// Quintics through position, velocity and acceleration are exact for quintics.
TEST(ResampledMotion, IsExactForQuintics) {
  VectorXd knots(4);
  knots << 0.2, 0.5, 0.9, 1.0;
  const VectorXd times = VectorXd::LinSpaced(57, 0.2, 1.0);
  const MotionSamples found = motion_at(polynomials(knots), times);
  const MotionSamples expected = polynomials(times);
  EXPECT_TRUE(near(found.q, expected.q, 1e-13));
  EXPECT_TRUE(near(found.dq, expected.dq, 1e-12));
  EXPECT_TRUE(near(found.ddq, expected.ddq, 1e-11));
}

TEST(ResampledMotion, HasTheRequestedRateAndKeepsItsRows) {
  const MotionSamples given = polynomials(VectorXd::LinSpaced(101, 2.0, 3.0));
  const MotionSamples faster = resampled(given, 250.0);
  ASSERT_EQ(faster.rows(), 251);
  EXPECT_NEAR(faster.time[250], 3.0, 1e-12);
  EXPECT_TRUE(near(faster.q.row(5), given.q.row(2), 1e-12));
  EXPECT_EQ(resampled(given, 7.0).rows(), 8);
  EXPECT_THROW(resampled(given, 0.0), InvalidInput);
  EXPECT_THROW(resampled(given, 1e12), InvalidInput);
}

TEST(ResampledMotion, IsConstantBeforeItsFirstAndAfterItsLastRow) {
  const MotionSamples given = polynomials(VectorXd::LinSpaced(3, 1.0, 2.0));
  VectorXd outside(2);
  outside << 0.0, 9.0;
  const MotionSamples found = motion_at(given, outside);
  EXPECT_EQ(found.q.row(0), given.q.row(0));
  EXPECT_EQ(found.q.row(1), given.q.row(2));
}

}  // namespace
}  // namespace veridyn
