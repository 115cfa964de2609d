#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "support/near.hpp"
#include "veridyn/control/quintic_interpolator.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

TEST(QuinticInterpolator, DerivativesMatchThePathAndTheGoalIsReached) {
  QuinticInterpolator way(Eigen::Vector2d(0.1, -0.3));
  ASSERT_TRUE(way.move_to(Eigen::Vector2d(0.105, 0.4), 1.0));
  const double h = 1e-4;
  VectorXd before = way.x();
  VectorXd speed = way.dx();
  double fastest = 0.0;
  double hardest = 0.0;
  for (int k = 0; k < 10000; ++k) {
    way.advance(h);
    // Midpoint rule: the error is h^2/24 of the third derivative.
    EXPECT_TRUE(near((way.x() - before) / h, 0.5 * (way.dx() + speed), 1e-6));
    EXPECT_TRUE(near((way.dx() - speed) / h, way.ddx(), 5e-3));
    before = way.x();
    speed = way.dx();
    fastest = std::max(fastest, std::abs(way.dx()[1]));
    hardest = std::max(hardest, std::abs(way.ddx()[1]));
  }
  EXPECT_TRUE(way.arrived());
  EXPECT_TRUE(near(way.x(), Eigen::Vector2d(0.105, 0.4), 0.0));
  EXPECT_EQ(way.dx().norm() + way.ddx().norm(), 0.0);
  // Textbook peaks of the move from rest to rest.
  EXPECT_NEAR(fastest, 1.875 * 0.7, 1e-6);
  EXPECT_NEAR(hardest, 10.0 / std::sqrt(3.0) * 0.7, 1e-4);
  EXPECT_NEAR(QuinticInterpolator::duration_for(0.7, fastest, 1e9), 1.0, 1e-6);
  EXPECT_NEAR(QuinticInterpolator::duration_for(-0.7, 1e9, hardest), 1.0, 1e-5);
}

TEST(QuinticInterpolator, ANewGoalKeepsVelocityAndAccelerationContinuous) {
  QuinticInterpolator way(Eigen::VectorXd::Zero(1));
  way.move_to(Eigen::VectorXd::Ones(1), 1.0);
  VectorXd x = way.x();
  VectorXd dx = way.dx();
  VectorXd ddx = way.ddx();
  const double h = 1e-3;
  for (int k = 0; k < 3000; ++k) {
    if (k == 400) {
      ASSERT_TRUE(way.move_to(Eigen::VectorXd::Constant(1, -0.5), 0.8));
    }
    if (k == 800) {
      ASSERT_TRUE(way.stop(0.3));
    }
    way.advance(h);
    // Bounds: the largest third derivative of these moves is below 1000.
    EXPECT_LT(std::abs(way.ddx()[0] - ddx[0]), 1000.0 * h) << k;
    EXPECT_LT(std::abs(way.dx()[0] - dx[0]), 40.0 * h) << k;
    EXPECT_LT(std::abs(way.x()[0] - x[0]), 6.0 * h) << k;
    x = way.x();
    dx = way.dx();
    ddx = way.ddx();
  }
  EXPECT_TRUE(way.arrived());
  EXPECT_EQ(way.dx()[0], 0.0);
}

TEST(QuinticInterpolator, InvalidGoalsAreRefusedAndChangeNothing) {
  EXPECT_THROW(QuinticInterpolator(VectorXd{}), InvalidInput);
  QuinticInterpolator way(Eigen::VectorXd::Zero(2));
  EXPECT_FALSE(way.move_to(Eigen::VectorXd::Ones(3), 1.0));
  EXPECT_FALSE(way.move_to(Eigen::Vector2d(NAN, 0.0), 1.0));
  EXPECT_FALSE(way.move_to(Eigen::VectorXd::Ones(2), 0.0));
  EXPECT_FALSE(way.move_to(Eigen::VectorXd::Ones(2), NAN));
  way.advance(1.0);
  EXPECT_EQ(way.x().norm(), 0.0);
  ASSERT_TRUE(way.move_to(Eigen::VectorXd::Ones(2), 1.0));
  way.advance(0.5);
  for (const double duration : {0.0, -1.0, HUGE_VAL, static_cast<double>(NAN)}) {
    EXPECT_FALSE(way.stop(duration)) << duration;
    EXPECT_EQ(way.goal(), Eigen::VectorXd::Ones(2)) << duration;
  }
  way.advance(0.5);
  EXPECT_EQ(way.x(), Eigen::VectorXd::Ones(2));
}

TEST(QuinticInterpolator, NonFiniteGoalsAndTimesChangeNothing) {
  QuinticInterpolator way(Eigen::Vector2d(0.1, 0.2));
  way.move_to(Eigen::Vector2d(0.3, 0.1), 1.0);
  way.advance(0.4);
  const VectorXd x = way.x(), dx = way.dx();
  way.reset(Eigen::Vector2d(NAN, 0.0));
  way.reset(VectorXd::Zero(3));
  way.advance(NAN);
  way.advance(-0.1);
  EXPECT_EQ(way.x(), x);
  EXPECT_EQ(way.dx(), dx);
  way.advance(0.6);
  EXPECT_EQ(way.x(), Eigen::Vector2d(0.3, 0.1));
}

}  // namespace
}  // namespace veridyn
