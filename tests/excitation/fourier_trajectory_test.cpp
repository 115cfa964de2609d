#include "veridyn/excitation/fourier_trajectory.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/near.hpp"
#include "support/random.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr double kFrequency = 0.17;
constexpr int kJoints = 3;
constexpr int kHarmonics = 5;

MatrixXd random_coefficients(Random& random) {
  MatrixXd c(kJoints, kHarmonics);
  for (double& x : c.reshaped()) x = random.in(-1.0, 1.0);
  return c;
}

FourierTrajectory random_trajectory(unsigned seed) {
  Random random(seed);
  MatrixXd a = random_coefficients(random);
  MatrixXd b = random_coefficients(random);
  rest_at_start(a, b);
  return {kFrequency, a, b, random.vector(kJoints, -1.0, 1.0)};
}

// Thesis (5.28) with the errata, term by term.
TEST(FourierTrajectory, PositionIsTheSeriesOfTheThesis) {
  const FourierTrajectory t = random_trajectory(1);
  const double time = 1.234;
  const VectorXd q = t.samples(VectorXd::Constant(1, time)).q.row(0).transpose();
  for (int i = 0; i < kJoints; ++i) {
    double expected = t.q0()[i];
    for (int l = 1; l <= kHarmonics; ++l) {
      const double w = 2.0 * M_PI * kFrequency * l;
      expected +=
          t.a()(i, l - 1) / w * std::sin(w * time) - t.b()(i, l - 1) / w * std::cos(w * time);
    }
    EXPECT_NEAR(q[i], expected, 1e-14);
  }
}

// Central differences with h = cbrt(eps): their error is h^2 / 6 times the third derivative, here
// below 1e4.
TEST(FourierTrajectory, VelocityAndAccelerationAreDerivatives) {
  const FourierTrajectory t = random_trajectory(2);
  const double h = std::cbrt(2.2e-16);
  for (const double time : {0.0, 0.3, 2.0, 5.5}) {
    VectorXd instants(3);
    instants << time - h, time, time + h;
    const MotionSamples s = t.samples(instants);
    const double tolerance = 1e4 * h * h;
    EXPECT_TRUE(near(s.dq.row(1), (s.q.row(2) - s.q.row(0)) / (2.0 * h), tolerance));
    EXPECT_TRUE(near(s.ddq.row(1), (s.dq.row(2) - s.dq.row(0)) / (2.0 * h), tolerance));
  }
}

TEST(FourierTrajectory, RestsAtTheStartOfEveryPeriod) {
  const FourierTrajectory t = random_trajectory(3);
  VectorXd instants(3);
  instants << 0.0, t.period(), 3.0 * t.period();
  const MotionSamples s = t.samples(instants);
  EXPECT_TRUE(near(s.dq, MatrixXd::Zero(3, kJoints), 1e-12));
  EXPECT_TRUE(near(s.ddq, MatrixXd::Zero(3, kJoints), 1e-11));
  EXPECT_TRUE(near(s.q.row(1), s.q.row(0), 1e-12));
}

TEST(FourierTrajectory, CoefficientsAlreadyAtRestAreUnchanged) {
  const FourierTrajectory t = random_trajectory(4);
  MatrixXd a = t.a();
  MatrixXd b = t.b();
  rest_at_start(a, b);
  EXPECT_TRUE(near(a, t.a(), 1e-14));
  EXPECT_TRUE(near(b, t.b(), 1e-14));
}

TEST(FourierTrajectory, TheSampledMotionIsPeriodicAndEndsAtRest) {
  const FourierTrajectory t = random_trajectory(5);
  const double rate = 1000.0 * kFrequency;  // a whole number of rows per period
  const MotionSamples m = t.motion(3, rate);
  ASSERT_EQ(m.rows(), 3001);
  EXPECT_TRUE(near(m.q.middleRows(0, 1000), m.q.middleRows(1000, 1000), 1e-12));
  EXPECT_TRUE(near(m.q.row(3000), m.q.row(0), 1e-12));
  EXPECT_TRUE(near(m.dq.row(3000), MatrixXd::Zero(1, kJoints), 1e-12));
}

// 0.17 Hz and 200 Hz: the period is not a whole number of rows.
TEST(FourierTrajectory, TheLastRowIsAtRestForAnyRate) {
  const FourierTrajectory t = random_trajectory(6);
  const MotionSamples m = t.motion(2, 200.0);
  EXPECT_GE(m.time[m.rows() - 1], 2.0 * t.period());
  EXPECT_LT(m.time[m.rows() - 2], 2.0 * t.period());
  EXPECT_TRUE(near(m.dq.row(m.rows() - 1), MatrixXd::Zero(1, kJoints), 1e-12));
  EXPECT_TRUE(near(m.q.row(m.rows() - 1), m.q.row(0), 1e-12));
}

TEST(FourierTrajectory, BoundsHoldBetweenSamplesAndAreTight) {
  for (unsigned seed = 10; seed < 20; ++seed) {
    const FourierTrajectory t = random_trajectory(seed);
    const MotionBounds bounds = t.bounds();
    const MotionSamples fine = t.samples(period_instants(kFrequency, 20011));
    for (int i = 0; i < kJoints; ++i) {
      const double highest = fine.q.col(i).maxCoeff();
      const double lowest = fine.q.col(i).minCoeff();
      const double speed = fine.dq.col(i).cwiseAbs().maxCoeff();
      const double acceleration = fine.ddq.col(i).cwiseAbs().maxCoeff();
      EXPECT_LE(highest, bounds.upper[i]);
      EXPECT_GE(lowest, bounds.lower[i]);
      EXPECT_LE(speed, bounds.velocity[i]);
      EXPECT_LE(acceleration, bounds.acceleration[i]);
      EXPECT_LE(bounds.upper[i] - bounds.lower[i], 1.01 * (highest - lowest));
      EXPECT_LE(bounds.velocity[i], 1.01 * speed);
      EXPECT_LE(bounds.acceleration[i], 1.02 * acceleration);
    }
  }
}

TEST(FourierTrajectory, RefusesSizesThatDiffer) {
  EXPECT_THROW(
      FourierTrajectory(0.1, MatrixXd::Zero(2, 3), MatrixXd::Zero(2, 4), VectorXd::Zero(2)),
      InvalidInput);
  EXPECT_THROW(
      FourierTrajectory(0.1, MatrixXd::Zero(2, 3), MatrixXd::Zero(2, 3), VectorXd::Zero(3)),
      InvalidInput);
  EXPECT_THROW(
      FourierTrajectory(0.0, MatrixXd::Zero(2, 3), MatrixXd::Zero(2, 3), VectorXd::Zero(2)),
      InvalidInput);
}

}  // namespace
}  // namespace veridyn
