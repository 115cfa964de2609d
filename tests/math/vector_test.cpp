#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "support/near.hpp"
#include "support/random.hpp"
#include "veridyn/math/vector3.hpp"

namespace veridyn {
namespace {

constexpr double kRounding = 1e-14;

Eigen::Vector3d eigen(const Vec3d& a) {
  return {a.x, a.y, a.z};
}

Eigen::Matrix3d eigen(const Mat3d& R) {
  Eigen::Matrix3d M;
  M << R.row0.x, R.row0.y, R.row0.z, R.row1.x, R.row1.y, R.row1.z, R.row2.x, R.row2.y, R.row2.z;
  return M;
}

Vec3d random_vector(Random& random) {
  return {random.in(-1, 1), random.in(-1, 1), random.in(-1, 1)};
}

TEST(Vector, ProductsEqualThoseOfEigen) {
  Random random(1);
  for (int k = 0; k < 20; ++k) {
    const Vec3d a = random_vector(random);
    const Vec3d b = random_vector(random);
    const Mat3d R = random.pose(1.0).R;
    const Mat3d Q = random.pose(1.0).R;
    EXPECT_NEAR(dot(a, b), eigen(a).dot(eigen(b)), kRounding);
    EXPECT_TRUE(near(eigen(cross(a, b)), eigen(a).cross(eigen(b)), kRounding));
    EXPECT_TRUE(near(eigen(rotate(R, a)), eigen(R) * eigen(a), kRounding));
    EXPECT_TRUE(near(eigen(rotate_back(R, a)), eigen(R).transpose() * eigen(a), kRounding));
    EXPECT_TRUE(near(eigen(R * Q), eigen(R) * eigen(Q), kRounding));
    EXPECT_TRUE(near(eigen(transpose(R)), eigen(R).transpose(), 0.0));
    EXPECT_TRUE(near(eigen(2.0 * a + b - a), 2.0 * eigen(a) + eigen(b) - eigen(a), kRounding));
  }
}

TEST(Rotation, TurnsByTheRightHandRule) {
  EXPECT_TRUE(near(eigen(rotation_x(0.7)),
                   Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitX()).matrix(), kRounding));
  EXPECT_TRUE(near(eigen(rotation_y(0.7)),
                   Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitY()).matrix(), kRounding));
  EXPECT_TRUE(near(eigen(rotation_z(0.7)),
                   Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()).matrix(), kRounding));
}

TEST(Pose, ComposesLikeHomogeneousMatricesAndInverts) {
  Random random(2);
  for (int k = 0; k < 20; ++k) {
    const Posed T_a_b = random.pose(1.0);
    const Posed T_b_c = random.pose(1.0);
    const Posed T_a_c = T_a_b * T_b_c;
    EXPECT_TRUE(near(eigen(T_a_c.R), eigen(T_a_b.R) * eigen(T_b_c.R), kRounding));
    EXPECT_TRUE(near(eigen(T_a_c.p), eigen(T_a_b.R) * eigen(T_b_c.p) + eigen(T_a_b.p), kRounding));
    const Posed I = T_a_b * inverse(T_a_b);
    EXPECT_TRUE(near(eigen(I.R), Eigen::Matrix3d::Identity(), kRounding));
    EXPECT_TRUE(near(eigen(I.p), Eigen::Vector3d::Zero(), kRounding));
  }
}

}  // namespace
}  // namespace veridyn
