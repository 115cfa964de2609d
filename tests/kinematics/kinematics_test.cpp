#include "veridyn/kinematics/kinematics.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "support/energy.hpp"
#include "support/near.hpp"
#include "support/sample_arms.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

class KinematicsOnEverySampleArm : public OnSampleArm {
 protected:
  static int frames() { return static_cast<int>(arm().frames().size()); }
};
INSTANTIATE_TEST_SUITE_P(Sample, KinematicsOnEverySampleArm, testing::ValuesIn(sample_arm_names()),
                         sample_arm_name);

constexpr double kRounding = 1e-14;
const double kStep = std::cbrt(std::numeric_limits<double>::epsilon());
const double kDifferenceError = 100 * kStep * kStep;  // f''' stays below 100 f on these arms

// [v; omega] of a frame from two poses a step apart: omega is the axial part of dR/dt R'.
VectorXd twist(const Eigen::Matrix4d& ahead, const Eigen::Matrix4d& behind,
               const Eigen::Matrix4d& here) {
  const Eigen::Matrix4d rate = (ahead - behind) / (2 * kStep);
  const Eigen::Matrix3d W = rate.topLeftCorner<3, 3>() * here.topLeftCorner<3, 3>().transpose();
  VectorXd v(6);
  v << rate.topRightCorner<3, 1>(), W(2, 1), W(0, 2), W(1, 0);
  return v;
}

TEST(Planar2R, TipAndJacobianAreTheClosedForm) {
  const Model arm = planar_2r();
  const double l = kPlanarLength1;
  const Eigen::Vector2d q(0.3, -1.1);
  const Eigen::Matrix4d T = frame_pose(arm, q, {1}).matrix();
  EXPECT_TRUE(
      near(T.col(3), Eigen::Vector4d(l * std::cos(0.3), 0, l * std::sin(0.3), 1), kRounding));
  EXPECT_TRUE(near(T.col(0), Eigen::Vector4d(std::cos(-0.8), 0, std::sin(-0.8), 0), kRounding));
  MatrixXd J(6, 2);  // the joints turn about -y of the world
  J << -l * std::sin(0.3), 0, 0, 0, l * std::cos(0.3), 0, 0, 0, -1, -1, 0, 0;
  EXPECT_TRUE(near(frame_jacobian(arm, q, {1}), J, kRounding));
}

// DH numbers by their definition, four elementary transforms.
TEST(Dh, BothConventionsEqualTheirFourElementaryTransforms) {
  const auto move = [](double z, double x) { return Posed{identity3(), {x, 0, z}}; };
  const auto turn = [](const Mat3d& R) { return Posed{R, {0, 0, 0}}; };
  for (const JointType type : {JointType::kFixed, JointType::kRevolute, JointType::kPrismatic}) {
    for (const DhConvention convention : {DhConvention::kStandard, DhConvention::kModified}) {
      const DhRow dh{convention, 0.3, 0.7, -0.2, 1.1};
      ArmBuilder builder("dh", 1, 1);
      builder.link(-1, JointType::kRevolute, {1.0}, 0.0, identity_pose(), identity_pose());
      builder.dh_link(type, 0, dh);
      if (type == JointType::kFixed)
        builder.description().frames.back().variable.coefficients.setZero();
      const double q = 0.4;
      const double theta = dh.theta + (type == JointType::kRevolute ? q : 0.0);
      const double d = dh.d + (type == JointType::kPrismatic ? q : 0.0);
      const Posed screw_z = turn(rotation_z(theta)) * move(d, 0);
      const Posed screw_x = turn(rotation_x(dh.alpha)) * move(0, dh.a);
      const Posed row =
          convention == DhConvention::kStandard ? screw_z * screw_x : screw_x * screw_z;
      const Posed T = turn(rotation_z(q)) * row;
      const Eigen::Matrix4d pose = frame_pose(builder.build(), VectorXd::Constant(1, q), {1}).matrix();
      EXPECT_TRUE(near(pose.col(3).head<3>(), Eigen::Vector3d(T.p.x, T.p.y, T.p.z), kRounding));
      EXPECT_TRUE(near(pose.row(0).head<3>(),
                       Eigen::RowVector3d(T.R.row0.x, T.R.row0.y, T.R.row0.z), kRounding));
      EXPECT_TRUE(near(pose.row(1).head<3>(),
                       Eigen::RowVector3d(T.R.row1.x, T.R.row1.y, T.R.row1.z), kRounding));
    }
  }
}

TEST_P(KinematicsOnEverySampleArm, PosesAreProductsOfHomogeneousMatrices) {
  for (const State& s : test_states(joints(), 51)) {
    const auto T_world = world_poses(arm(), std::vector<double>(s.q.begin(), s.q.end()));
    for (int k = 0; k < frames(); ++k) {
      Eigen::Matrix4d expected;
      for (int i = 0; i < 16; ++i) expected(i / 4, i % 4) = T_world[k][i / 4][i % 4];
      EXPECT_TRUE(near(frame_pose(arm(), s.q, {k}).matrix(), expected, 100 * kRounding)) << "frame " << k;
    }
  }
}

TEST_P(KinematicsOnEverySampleArm, JacobianMatchesCentralDifferencesOfThePose) {
  for (const State& s : test_states(joints(), 52)) {
    for (int k = 0; k < frames(); ++k) {
      const MatrixXd J = frame_jacobian(arm(), s.q, {k});
      for (int i = 0; i < joints(); ++i) {
        const VectorXd step = kStep * VectorXd::Unit(joints(), i);
        const VectorXd v = twist(frame_pose(arm(), s.q + step, {k}).matrix(), frame_pose(arm(), s.q - step, {k}).matrix(),
                                 frame_pose(arm(), s.q, {k}).matrix());
        EXPECT_TRUE(near(J.col(i), v, kDifferenceError)) << "frame " << k << ", coordinate " << i;
      }
    }
  }
}

TEST_P(KinematicsOnEverySampleArm, JacobianRateMatchesCentralDifferencesOfTheJacobian) {
  for (const State& s : test_states(joints(), 53)) {
    for (int k = 0; k < frames(); ++k) {
      const MatrixXd ahead = frame_jacobian(arm(), s.q + kStep * s.dq, {k});
      const MatrixXd behind = frame_jacobian(arm(), s.q - kStep * s.dq, {k});
      const MatrixXd dJ = frame_jacobian_rate(arm(), s.q, s.dq, {k});
      EXPECT_TRUE(near(dJ, (ahead - behind) / (2 * kStep),
                       kDifferenceError * (1 + s.dq.squaredNorm() * s.dq.norm())))
          << "frame " << k;
    }
  }
}

TEST(Kinematics, WrongSizesAndFramesAreNamed) {
  const Model arm = elbow_6r();
  const VectorXd six = VectorXd::Zero(6);
  const VectorXd five = VectorXd::Zero(5);
  EXPECT_THROW(frame_pose(arm, five, {0}), InvalidInput);
  EXPECT_THROW(frame_pose(arm, six, {6}), InvalidInput);
  EXPECT_THROW(frame_jacobian(arm, six, {-1}), InvalidInput);
  EXPECT_THROW(frame_jacobian_rate(arm, six, five, {0}), InvalidInput);
}

}  // namespace
}  // namespace veridyn
