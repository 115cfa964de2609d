#include "control/safety/position_limit.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace veridyn {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kEndless = std::numeric_limits<double>::infinity();

TEST(PositionLimit, AJointThatCannotBrakeBeforeItsLimitLeavesItsRange) {
  const PositionRange range{-1.0, 1.0};
  EXPECT_FALSE(leaves_range(0.9, 0.9, range, 10.0));  // 0.99
  EXPECT_TRUE(leaves_range(0.9, 1.1, range, 10.0));   // 1.01
  EXPECT_FALSE(leaves_range(-0.9, -0.9, range, 10.0));
  EXPECT_TRUE(leaves_range(-0.9, -1.1, range, 10.0));
  EXPECT_FALSE(leaves_range(1.2, -0.1, range, 10.0));  // on its way back
  EXPECT_TRUE(leaves_range(1.2, 0.0, range, 10.0));
}

TEST(PositionLimit, NonFinitePositionsAreOutsideEveryRange) {
  const PositionRange range{-1.0, 1.0};
  EXPECT_TRUE(leaves_range(kNone, 0.0, range, 10.0));
  EXPECT_TRUE(leaves_range(0.0, kNone, range, 10.0));
  EXPECT_TRUE(leaves_range(kEndless, 0.0, range, 10.0));
  EXPECT_FALSE(leaves_range(1e9, 1e9, {-kEndless, kEndless}, 10.0));
}

}  // namespace
}  // namespace veridyn
