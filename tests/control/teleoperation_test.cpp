#include "veridyn/control/teleoperation.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

using Eigen::Vector3d;

const Vector3d kLeader(0.1, 0.2, 0.3), kFollower(-0.3, 0.0, 0.1);

TeleoperationOptions turned() {
  TeleoperationOptions o;
  o.scale = 0.4;
  o.R_follower_leader = Eigen::AngleAxisd(M_PI / 2.0, Vector3d::UnitZ()).toRotationMatrix();
  return o;
}

TEST(Teleoperation, AppliesScaleRotationAndClutch) {
  Teleoperation tele(turned(), kLeader, kFollower);
  const Vector3d none = Vector3d::Zero();
  tele.update(kLeader + Vector3d(0.1, 0.0, 0.0), none, none);  // the clutch is out
  EXPECT_EQ(tele.follower().position, kFollower);
  tele.clutch(true);
  tele.update(kLeader, none, none);
  EXPECT_EQ(tele.follower().position, kFollower);
  Vector3d leader = kLeader;
  const Vector3d velocity(0.05, 0.0, 0.0);
  for (int k = 0; k < 200; ++k) {
    leader += 1e-3 * velocity;
    tele.update(leader, velocity, none);
  }
  // x of the leader is y of the follower, 0.4 times as far.
  EXPECT_LT((tele.follower().position - kFollower - Vector3d(0.0, 0.004, 0.0)).norm(), 1e-12);
  EXPECT_LT((tele.follower().velocity - Vector3d(0.0, 0.02, 0.0)).norm(), 1e-12);
  tele.clutch(false);
  tele.update(kLeader, none, none);
  tele.clutch(true);
  tele.update(kLeader - Vector3d(0.2, 0.0, 0.0), none, none);  // elsewhere: no jump
  EXPECT_LT((tele.follower().position - kFollower - Vector3d(0.0, 0.004, 0.0)).norm(), 1e-12);
}

TEST(Teleoperation, ReflectedForcesAreBounded) {
  Teleoperation tele(turned(), kLeader, kFollower);
  tele.clutch(true);
  const Vector3d none = Vector3d::Zero();
  tele.update(kLeader, none, {0.0, 3.0, 0.0});
  EXPECT_LT(tele.leader_force().norm(), 0.1);  // over `ramp`
  for (int k = 0; k < 1000; ++k) tele.update(kLeader, none, {0.0, 3.0, 0.0});
  // y of the follower is x of the leader; what pushes the follower's object pushes the hand back.
  EXPECT_LT((tele.leader_force() - Vector3d(-3.0, 0.0, 0.0)).norm(), 1e-9);
  for (int k = 0; k < 1000; ++k) tele.update(kLeader, none, {0.0, 30.0, 0.0});
  EXPECT_NEAR(tele.leader_force().norm(), 5.0, 1e-9);
  tele.update(kLeader, {0.1, 0.0, 0.0}, none);
  EXPECT_LT(tele.leader_force().x(), -0.4);  // damping
}

TEST(Teleoperation, AWrongVelocityMeasurementDoesNotExceedTheSpeedLimit) {
  Teleoperation tele(turned(), kLeader, kFollower);
  tele.clutch(true);
  const Vector3d none = Vector3d::Zero();
  tele.update(kLeader, none, none);
  tele.update(kLeader, {50.0, 0.0, 0.0}, none);  // at rest
  EXPECT_LT((tele.follower().velocity - Vector3d(0.0, TeleoperationOptions().speed, 0.0)).norm(), 1e-12);
  EXPECT_EQ(tele.follower().position, kFollower);
}

TEST(Teleoperation, NeverExceedsItsSpeedAndReleasesOnNonFiniteInput) {
  Teleoperation tele(turned(), kLeader, kFollower);
  tele.clutch(true);
  const Vector3d none = Vector3d::Zero();
  tele.update(kLeader, none, none);
  Vector3d before = tele.follower().position;
  for (int k = 0; k < 100; ++k) {
    tele.update(kLeader + Vector3d(1.0, 0.0, 0.0), none, none);
    EXPECT_LE((tele.follower().position - before).norm(), 0.2e-3 + 1e-12);
    before = tele.follower().position;
  }
  tele.update(Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()), none, none);
  EXPECT_FALSE(tele.is_engaged());
  EXPECT_EQ(tele.follower().position, before);
  EXPECT_EQ(tele.leader_force(), none);
  TeleoperationOptions bad;
  bad.scale = 0.0;
  EXPECT_THROW(Teleoperation(bad, kLeader, kFollower), InvalidInput);
}

}  // namespace
}  // namespace veridyn
