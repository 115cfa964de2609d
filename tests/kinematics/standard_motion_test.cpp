#include "kinematics/standard_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "kinematics/motion_limits.hpp"
#include "veridyn/files/model_file.hpp"

namespace veridyn {
namespace {

TEST(TheStandardMotion, StaysWithinEveryRobotsLimitsAndMovesEveryJoint) {
  for (const std::string& name : robot_names()) {
    SCOPED_TRACE(name);
    const Model arm = read_model(name);
    const MotionLimits limits = motion_limits(arm);
    const MotionSamples m = standard_motion(arm);
    for (Eigen::Index i = 0; i < arm.joints(); ++i) {
      EXPECT_GT(m.q.col(i).minCoeff(), limits.lower[i]);
      EXPECT_LT(m.q.col(i).maxCoeff(), limits.upper[i]);
      EXPECT_LT(m.dq.col(i).cwiseAbs().maxCoeff(), limits.velocity[i]);
      EXPECT_LT(m.ddq.col(i).cwiseAbs().maxCoeff(), limits.acceleration[i]);
      EXPECT_GT(m.dq.col(i).cwiseAbs().maxCoeff(), 0.0);
    }
  }
}

// A limit that is tight on acceleration alone is kept, too.
TEST(TheStandardMotion, StaysWithinATightAccelerationLimit) {
  ModelDescription d = read_model("planar-2r").description();
  d.coordinates[1].limits.acceleration = 0.01;
  EXPECT_LT(standard_motion(Model(d)).ddq.col(1).cwiseAbs().maxCoeff(), 0.01);
}

TEST(TheStandardMotion, HasTheDerivativesOfItsPositions) {
  const Model arm = read_model("psm-wrist");
  const MotionSamples m = standard_motion(arm);
  const double dt = m.time[1] - m.time[0];
  for (Eigen::Index i = 0; i < arm.joints(); ++i) {
    const double omega = 2.0 * M_PI * standard_frequency(static_cast<int>(i));
    for (Eigen::Index k = 100; k < 2900; k += 100) {
      // Central differences of a sine are off by (omega dt)^2 / 6 of its derivative.
      const double error = omega * omega * dt * dt / 6.0;
      EXPECT_NEAR((m.q(k + 1, i) - m.q(k - 1, i)) / (2.0 * dt), m.dq(k, i),
                  error * m.dq.col(i).cwiseAbs().maxCoeff());
      EXPECT_NEAR((m.dq(k + 1, i) - m.dq(k - 1, i)) / (2.0 * dt), m.ddq(k, i),
                  error * m.ddq.col(i).cwiseAbs().maxCoeff());
    }
  }
}

}  // namespace
}  // namespace veridyn
