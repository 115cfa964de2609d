#include "dvrk/arms/arm_kinematics.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "support/near.hpp"
#include "support/random.hpp"
#include "veridyn/kinematics/kinematics.hpp"
#include "veridyn/math/require.hpp"
#include "veridyn/files/model_file.hpp"
#include "support/refusal.hpp"

namespace veridyn::dvrk {
namespace {

// Uniform within the limits of the joints that have rows.
VectorXd within_limits(const ArmFacts& arm, Random& random) {
  VectorXd q(arm.kinematic_joints());
  for (int k = 0; k < q.size(); ++k) {
    const ArmJoint& joint = arm.joints[k];
    q[k] = random.in(joint.lower, joint.upper);
  }
  return q;
}

// The poses that the closed forms invert, from the generic recursion.
class Chain {
 public:
  explicit Chain(const ArmFacts& arm) : model_(arm_model(arm)) {}
  Eigen::Matrix4d forward(const VectorXd& q) const {
    return frame_pose(model_, q, *model_.find_frame("tip")).matrix();
  }
  // Intersection of an MTM's last four axes.
  Eigen::Vector3d wrist_position(const Eigen::Vector3d& q) const {
    VectorXd all = VectorXd::Zero(model_.joints());
    all.head<3>() = q;
    return frame_pose(model_, all, {3}).translation();
  }

 private:
  Model model_;
};

// inverse(forward(q)) = q for every q within the limits, from a random start.
// Errors of rounding grow with the inverse of the distances to the singular places.
TEST(ArmKinematics, PsmInverseFindsTheJoints) {
  const ArmFacts arm = read_arm("PSM1");
  const PsmKinematics kinematics(arm);
  const Chain chain(arm);
  Random random(2);
  for (int trial = 0; trial < 2000; ++trial) {
    const PsmKinematics::Joints q = within_limits(arm, random);
    PsmKinematics::Joints near_q = within_limits(arm, random);
    // The roll has more than a turn: a near start determines which turn is meant.
    near_q[3] = q[3] + random.in(-3.0, 3.0);
    const InverseSolution<6> found = kinematics.inverse(chain.forward(q), near_q);
    EXPECT_EQ(found.status, InverseStatus::kDone);
    const double length = std::abs(q[2] - 0.0156);
    EXPECT_TRUE(near(found.q, q, 1e-13 + 1e-15 / length)) << trial << ": " << q.transpose();
  }
}

TEST(ArmKinematics, PsmReachesThePoseAtItsSingularities) {
  const ArmFacts arm = read_arm("PSM1");
  const PsmKinematics kinematics(arm);
  const Chain chain(arm);
  Random random(3);
  for (const double distance : {0.0, 1e-12, 1e-10, 1e-8, 1e-5, -1e-8, -1e-12}) {
    for (int trial = 0; trial < 50; ++trial) {
      PsmKinematics::Joints q = within_limits(arm, random);
      q[2] = 0.4318 - 0.4162 + distance;  // the wrist in the remote centre
      // Joints taken from `near` must be within the limits, so it starts close.
      PsmKinematics::Joints near_q = q;
      near_q[0] += random.in(-0.05, 0.05);
      near_q[1] += random.in(-0.05, 0.05);
      const Eigen::Matrix4d T = chain.forward(q);
      const InverseSolution<6> found = kinematics.inverse(T, near_q);
      EXPECT_NE(found.status, InverseStatus::kOutOfReach);
      if (std::abs(distance) <= 1e-10 && found.status != InverseStatus::kOutsideLimits) {
        EXPECT_EQ(found.status, InverseStatus::kSingular) << distance;
      }
      // Below kSingularDistance the shaft's direction is guessed: the tip is off by no more.
      EXPECT_TRUE(near(chain.forward(found.q), T, 1e-9)) << distance;
    }
  }
}

// The wrist in the remote centre, and the axis of wrist pitch that `near` proposes along that of wrist yaw: any axis
// perpendicular to the latter is a solution, in either direction.
TEST(ArmKinematics, PsmReachesThePoseWithItsWristInTheRemoteCentre) {
  ArmFacts arm = read_arm("PSM1");
  arm.T_last_tip.setIdentity();
  const PsmKinematics kinematics(arm);
  const Chain chain(arm);
  for (const auto& [axis, roll] : {std::pair(Eigen::Vector3d::UnitX().eval(), 0.0), std::pair(Eigen::Vector3d::UnitY().eval(), M_PI / 2.0)}) {
    Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
    T.col(0).head<3>() = Eigen::Vector3d(axis.y(), axis.x(), 0.0);
    T.col(1).head<3>() = axis.cross(T.col(0).head<3>());
    T.col(2).head<3>() = axis;
    const InverseSolution<6> found = kinematics.inverse(T, PsmKinematics::Joints::Unit(3) * roll);
    EXPECT_NE(found.status, InverseStatus::kOutOfReach);
    EXPECT_TRUE(near(chain.forward(found.q), T, 1e-9)) << roll << ": " << found.q.transpose();
  }
}

TEST(ArmKinematics, PsmSolutionsBeyondLimitsAreMarkedAndReachThePose) {
  const ArmFacts arm = read_arm("PSM1");
  const PsmKinematics kinematics(arm);
  const Chain chain(arm);
  Random random(4);
  for (int trial = 0; trial < 200; ++trial) {
    PsmKinematics::Joints q = within_limits(arm, random);
    q[2] = random.in(0.25, 0.5);
    const Eigen::Matrix4d T = chain.forward(q);
    const InverseSolution<6> found = kinematics.inverse(T, q);
    EXPECT_EQ(found.status, InverseStatus::kOutsideLimits);
    EXPECT_TRUE(near(found.q, q, 1e-12));
  }
  // The axis of wrist yaw through the remote centre: wrist pitch beyond 90 degrees, any roll.
  PsmKinematics::Joints q;
  q << 0.3, 0.2, 0.1156, 0.4, std::acos(-0.0091 / 0.1), 0.5;
  const Eigen::Matrix4d T = chain.forward(q);
  const InverseSolution<6> found = kinematics.inverse(T, q);
  EXPECT_EQ(found.status, InverseStatus::kOutsideLimits);
  EXPECT_TRUE(near(chain.forward(found.q), T, 1e-7));
}

TEST(ArmKinematics, AnInvalidPoseLeavesTheJointsUnchanged) {
  const PsmKinematics psm(read_arm("PSM1"));
  const MtmKinematics mtm(read_arm("MTML"));
  const EcmKinematics ecm(read_arm("ECM"));
  const Eigen::Matrix4d bad = Eigen::Matrix4d::Constant(std::nan(""));
  const PsmKinematics::Joints q6 = PsmKinematics::Joints::Constant(0.1);
  const MtmKinematics::Joints q7 = MtmKinematics::Joints::Constant(0.1);
  EXPECT_EQ(psm.inverse(bad, q6).status, InverseStatus::kOutOfReach);
  EXPECT_EQ(psm.inverse(bad, q6).q, q6);
  EXPECT_EQ(mtm.inverse(bad, q7).status, InverseStatus::kOutOfReach);
  EXPECT_EQ(mtm.inverse(bad, q7).q, q7);
  EXPECT_EQ(ecm.inverse(bad, Eigen::Vector4d::Zero()).status, InverseStatus::kOutOfReach);
  // A single column, and products beyond the largest number.
  const Eigen::Vector4d q4(0.1, 0.1, 0.1, 0.1);
  Eigen::Matrix4d turned = Chain(read_arm("ECM")).forward(q4);
  turned.topLeftCorner<3, 1>().setConstant(std::nan(""));
  EXPECT_EQ(ecm.inverse(turned, q4).status, InverseStatus::kOutOfReach);
  EXPECT_EQ(ecm.inverse(turned, q4).q, q4);
  Eigen::Matrix4d far = Eigen::Matrix4d::Identity();
  far.topRightCorner<3, 1>().setConstant(1e200);
  EXPECT_EQ(psm.inverse(far, q6).status, InverseStatus::kOutOfReach);
  EXPECT_EQ(psm.inverse(far, q6).q, q6);
}

TEST(ArmKinematics, EcmInverseFindsTheJointsAndRefusesUnreachablePoses) {
  const ArmFacts arm = read_arm("ECM");
  const EcmKinematics kinematics(arm);
  const Chain chain(arm);
  Random random(5);
  for (int trial = 0; trial < 500; ++trial) {
    const Eigen::Vector4d q = within_limits(arm, random);
    const Eigen::Matrix4d T = chain.forward(q);
    const InverseSolution<4> found = kinematics.inverse(T, within_limits(arm, random));
    EXPECT_EQ(found.status, InverseStatus::kDone);
    EXPECT_TRUE(near(found.q, q, 1e-13));
    Eigen::Matrix4d tilted = T;
    tilted.topLeftCorner<3, 3>() *=
        Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitX()).toRotationMatrix();
    if (q[2] < 0.01) continue;
    EXPECT_EQ(kinematics.inverse(tilted, q).status, InverseStatus::kOutOfReach);
  }
  // The tip in the remote centre: the axis determines yaw and pitch nevertheless.
  const Eigen::Vector4d q(0.3, 0.2, 0.3822 - 0.3829, 0.4);
  EXPECT_TRUE(near(kinematics.inverse(chain.forward(q), Eigen::Vector4d::Zero()).q, q, 1e-13));
}

TEST(ArmKinematics, MtmInverseFindsTheJoints) {
  const ArmFacts arm = read_arm("MTML");
  const MtmKinematics kinematics(arm);
  const Chain chain(arm);
  Random random(6);
  int others = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const MtmKinematics::Joints q = within_limits(arm, random);
    MtmKinematics::Joints near_q = q;
    for (const int k : {0, 1, 2}) near_q[k] += random.in(-0.2, 0.2);
    for (const int k : {4, 5, 6}) near_q[k] += random.in(-1.5, 1.5);
    const Eigen::Matrix4d T = chain.forward(q);
    const InverseSolution<7> found = kinematics.inverse(T, near_q);
    EXPECT_EQ(found.status, InverseStatus::kDone) << trial;
    // Where the wrist is near the axis of yaw, or the elbow near stretched, a neighbour may be
    // nearer.
    if ((found.q - q).norm() > 1e-10) ++others;
    const Eigen::Vector3d wrist = chain.wrist_position(q.head<3>());
    EXPECT_TRUE(near(chain.wrist_position(found.q.head<3>()), wrist, 1e-12));
    EXPECT_TRUE(
        near(chain.forward(found.q), T, 1e-7 / (0.01 + std::hypot(wrist.x(), wrist.y()))));
  }
  EXPECT_LT(others, 20);
}

// Beyond the limits the nearest of all solutions is given, whichever way the elbow bends and
// whether the arm reaches forwards or over its own base.
TEST(ArmKinematics, MtmInverseIsNearestBeyondTheLimits) {
  const ArmFacts arm = read_arm("MTML");
  const MtmKinematics kinematics(arm);
  const Chain chain(arm);
  Random random(8);
  int outside = 0;
  for (int trial = 0; trial < 500; ++trial) {
    const Eigen::Vector3d q = random.vector(3, -3.0, 3.0);
    const InverseSolution<3> found = kinematics.inverse_position(chain.wrist_position(q), q);
    if (found.status != InverseStatus::kOutsideLimits) continue;
    ++outside;
    EXPECT_TRUE(near(found.q, q, 1e-6));
  }
  EXPECT_GT(outside, 250);
}

TEST(ArmKinematics, MtmPositionsOutOfReachAreReported) {
  const ArmFacts arm = read_arm("MTML");
  const MtmKinematics kinematics(arm);
  const Chain chain(arm);
  const double reach = 0.2794 + std::hypot(0.3645, 0.151);
  const Eigen::Vector3d shoulder(0, 0, -0.2154);
  const Eigen::Vector3d direction = Eigen::Vector3d(-0.5, 0.1, -0.6).normalized();
  EXPECT_EQ(kinematics.inverse_position(shoulder + 1.0001 * reach * direction, {0, 0, 0}).status,
            InverseStatus::kOutOfReach);
  const Eigen::Vector3d stretched = shoulder + reach * direction;
  const InverseSolution<3> found = kinematics.inverse_position(stretched, {0, 0, 0});
  EXPECT_NE(found.status, InverseStatus::kOutOfReach);
  EXPECT_TRUE(near(chain.wrist_position(found.q), stretched, 1e-12));
  // Straight above the shoulder any yaw will do: it stays.
  const Eigen::Vector3d above(0, 0, -0.2154 - 0.4);
  const InverseSolution<3> on_axis = kinematics.inverse_position(above, {0.123, 0.2, 0.1});
  EXPECT_NEAR(on_axis.q[0], 0.123, 1e-15);
  EXPECT_TRUE(near(chain.wrist_position(on_axis.q), above, 1e-12));
}

// At wrist yaw of 90 degrees pitch and roll turn about one line; pitch stays, the pose is reached.
TEST(ArmKinematics, MtmReachesThePoseInGimbalLock) {
  const ArmFacts arm = read_arm("MTML");
  const MtmKinematics kinematics(arm);
  const Chain chain(arm);
  MtmKinematics::Joints q;
  q << 0.1, 0.3, 0.2, 0.4, 0.7, M_PI / 2.0, -1.0;
  const Eigen::Matrix4d T = chain.forward(q);
  const InverseSolution<7> found = kinematics.inverse(T, q);
  EXPECT_TRUE(near(chain.forward(found.q), T, 1e-9));
}

// The published model of the same arm (IEEE RA-L 4(4), 2019), written down by others in other
// frames: base and tool differ by one constant pose each, for all joint angles.
TEST(ArmKinematics, ThePsmMovesAsThePublishedModelDoes) {
  const Model published = read_model("psm-wrist");
  ArmFacts arm = read_arm("PSM1");
  arm.T_last_tip.setIdentity();  // the published model ends at the axis of wrist yaw
  const Chain chain(arm);
  const auto published_pose = [&](const PsmKinematics::Joints& q) {
    VectorXd motors = VectorXd::Zero(7);
    motors.head<4>() = q.head<4>();
    motors[4] = q[4] / 1.0186;
    motors[5] = (q[5] + 0.8306 * motors[4]) / 1.2178;
    return frame_pose(published, motors, *published.find_frame("yaw1")).matrix();
  };
  // T_published(q) = X T(q) Y for all q: turns and ways between any two configurations have the
  // same angle and length in both.
  Random random(7);
  PsmKinematics::Joints before = PsmKinematics::Joints::Zero();
  for (int trial = 0; trial < 100; ++trial) {
    const PsmKinematics::Joints q = within_limits(arm, random);
    const Eigen::Matrix4d T1 = chain.forward(before), T2 = chain.forward(q);
    const Eigen::Matrix4d P1 = published_pose(before), P2 = published_pose(q);
    const auto turn = [](const Eigen::Matrix4d& A, const Eigen::Matrix4d& B) {
      return (A.topLeftCorner<3, 3>() * B.topLeftCorner<3, 3>().transpose()).trace();
    };
    const auto way = [](const Eigen::Matrix4d& A, const Eigen::Matrix4d& B) {
      return (A.col(3) - B.col(3)).norm();
    };
    EXPECT_NEAR(turn(T1, T2), turn(P1, P2), 1e-9) << q.transpose();
    EXPECT_NEAR(way(T1, T2), way(P1, P2), 1e-9) << q.transpose();
    before = q;
  }
}

// Angles of more than a turn: the turn nearest to where the arm is, unless it is out of range.
TEST(ArmKinematics, SolutionsAreShiftedByWholeTurnsIntoTheRange) {
  const JointRanges<6> ranges(read_arm("PSM1"));  // roll: 272 degrees either way
  using Joints = PsmKinematics::Joints;
  const double limit = ranges.upper[3];
  const auto wrapped = [&](double roll, double near_roll) {
    Joints q = Joints::Unit(3) * roll;
    ranges.wrap(q, Joints::Unit(3) * near_roll);
    return q[3];
  };
  EXPECT_NEAR(wrapped(-1.0, 0.0), -1.0, 1e-15);
  EXPECT_NEAR(wrapped(-3.0, 2.0), -3.0 + 2.0 * M_PI, 1e-15);  // 3.28, nearer
  EXPECT_NEAR(wrapped(-1.0, 4.0), -1.0, 1e-15);               // 5.28 is beyond the limit
  EXPECT_NEAR(wrapped(1.0, -4.0), 1.0, 1e-15);                // and so is -5.28
  EXPECT_NEAR(wrapped(limit + 1e-12, limit), limit, 1e-11);   // rounding is no turn
  EXPECT_NEAR(wrapped(1.0 + 6.0 * M_PI, 0.0), 1.0, 1e-13);
  // An angle that no turn brings into the range stays the one nearest to where the arm is.
  JointRanges<6> narrow = ranges;
  narrow.lower[3] = -0.5;
  narrow.upper[3] = 0.5;
  for (const double side : {1.0, -1.0}) {
    Joints q = Joints::Unit(3) * side;
    narrow.wrap(q, Joints::Zero());
    EXPECT_NEAR(q[3], side, 1e-15);
    EXPECT_FALSE(narrow.contain(q));
  }
}

TEST(ArmKinematics, DhTablesOfAnotherArmTypeAreRefused) {
  ArmFacts arm = read_arm("PSM1");
  EXPECT_THROW(EcmKinematics{arm}, InvalidInput);
  EXPECT_THROW(MtmKinematics{arm}, InvalidInput);
  arm.joints[4].dh->a = 0.001;
  EXPECT_TRUE(refuses_with("PSM1: joint wrist_pitch", [&] { PsmKinematics{arm}; }));
}

}  // namespace
}  // namespace veridyn::dvrk
