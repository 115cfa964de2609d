#include "veridyn/dynamics/rigid_body_dynamics.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

#include "support/near.hpp"
#include "support/sample_arms.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

class OnEverySampleArm : public OnSampleArm {};
INSTANTIATE_TEST_SUITE_P(Sample, OnEverySampleArm, testing::ValuesIn(all_arm_names()),
                         sample_arm_name);

constexpr double kRounding = 1e-13;  // relative; both sides add some thousand products
const double kStep = std::cbrt(std::numeric_limits<double>::epsilon());
// Central differences err by h^2/6 f''' + eps/h f; these arms have f''' below 100 f.
const double kDifferenceError = 100 * kStep * kStep;

VectorXd torques(const Model& arm, const VectorXd& q, const VectorXd& dq, const VectorXd& ddq) {
  return inverse_dynamics(arm, q, dq, ddq);
}

VectorXd gravity(const Model& arm, const VectorXd& q) {
  const VectorXd rest = VectorXd::Zero(q.size());
  return torques(arm, q, rest, rest);
}

VectorXd velocity_torques(const Model& arm, const State& s) {
  return torques(arm, s.q, s.dq, VectorXd::Zero(s.q.size())) - gravity(arm, s.q);
}

MatrixXd mass_matrix_rate(const Model& arm, const State& s) {
  return (mass_matrix(arm, s.q + kStep * s.dq) - mass_matrix(arm, s.q - kStep * s.dq)) /
         (2 * kStep);
}

// c = dM/dt dq - 1/2 d(dq' M dq)/dq
VectorXd velocity_torques_from_mass_matrix(const Model& arm, const State& s) {
  VectorXd c = mass_matrix_rate(arm, s) * s.dq;
  for (int i = 0; i < arm.joints(); ++i) {
    VectorXd ahead = s.q;
    VectorXd behind = s.q;
    ahead[i] += kStep;
    behind[i] -= kStep;
    c[i] -=
        0.5 * s.dq.dot((mass_matrix(arm, ahead) - mass_matrix(arm, behind)) * s.dq) / (2 * kStep);
  }
  return c;
}

TEST_P(OnEverySampleArm, RegressorTimesParametersIsInverseDynamics) {
  for (const State& s : test_states(joints(), 11)) {
    const VectorXd tau = torques(arm(), s.q, s.dq, s.ddq);
    const VectorXd Y_phi = torque_regressor(arm(), s.q, s.dq, s.ddq) * phi();
    EXPECT_TRUE(near(Y_phi, tau, kRounding * (10 + tau.norm())));
  }
}

// Each column of Y is the torque of a unit parameter, whether or not a body could have it.
TEST_P(OnEverySampleArm, RegressorColumnsAreTorquesOfUnitParameters) {
  for (const State& s : test_states(joints(), 12)) {
    const MatrixXd Y = torque_regressor(arm(), s.q, s.dq, s.ddq);
    VectorXd tau(joints());
    for (Eigen::Index c = 0; c < Y.cols(); ++c) {
      RigidBodyDynamics unit(arm(), VectorXd::Unit(Y.cols(), c));
      unit.inverse_dynamics(s.q, s.dq, s.ddq, tau);
      EXPECT_TRUE(near(Y.col(c), tau, kRounding * (10 + Y.norm()))) << "column " << c;
    }
  }
}

// Column j of M is the torque that a unit acceleration of coordinate j needs.
TEST_P(OnEverySampleArm, MassMatrixColumnsAreTorquesOfUnitAccelerations) {
  for (const State& s : test_states(joints(), 13)) {
    const MatrixXd M = mass_matrix(arm(), s.q);
    const VectorXd rest = VectorXd::Zero(joints());
    const VectorXd g = gravity(arm(), s.q);
    for (int j = 0; j < joints(); ++j) {
      const VectorXd column = torques(arm(), s.q, rest, VectorXd::Unit(joints(), j)) - g;
      EXPECT_TRUE(near(M.col(j), column, kRounding * (10 + M.norm() + g.norm())));
    }
  }
}

TEST_P(OnEverySampleArm, MassMatrixIsSymmetricAndPositiveDefinite) {
  for (const State& s : test_states(joints(), 14)) {
    const MatrixXd M = mass_matrix(arm(), s.q);
    EXPECT_TRUE(near(M, M.transpose(), 0.0));
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<MatrixXd>(M).eigenvalues()[0], 0.0);
  }
}

// Velocity torques follow from the mass matrix alone.
// (Energy balance is blind to forces that do no work, such as the gyroscopic one; this is not.)
TEST_P(OnEverySampleArm, VelocityTorquesFollowFromTheMassMatrix) {
  for (const State& s : test_states(joints(), 15)) {
    const VectorXd c = velocity_torques(arm(), s);
    const double scale = mass_matrix(arm(), s.q).norm() * (1 + s.dq.squaredNorm() * s.dq.norm());
    EXPECT_TRUE(near(c, velocity_torques_from_mass_matrix(arm(), s), kDifferenceError * scale));
  }
}

TEST_P(OnEverySampleArm, CoriolisMatrixTimesVelocityIsTheVelocityTorque) {
  for (const State& s : test_states(joints(), 16)) {
    const VectorXd c = velocity_torques(arm(), s);
    const double scale = 10 + c.norm() + gravity(arm(), s.q).norm();
    EXPECT_TRUE(near(coriolis_matrix(arm(), s.q, s.dq) * s.dq, c, kRounding * scale));
  }
}

TEST_P(OnEverySampleArm, MassMatrixRateMinusTwiceCoriolisIsSkew) {
  for (const State& s : test_states(joints(), 17)) {
    const MatrixXd C = coriolis_matrix(arm(), s.q, s.dq);
    const double scale = mass_matrix(arm(), s.q).norm() * (1 + s.dq.squaredNorm() * s.dq.norm());
    EXPECT_TRUE(near(mass_matrix_rate(arm(), s), C + C.transpose(), kDifferenceError * scale));
  }
}

// C is linear in dq, so that C(q, a) b is the bilinear form of an observer or a passive controller.
TEST_P(OnEverySampleArm, CoriolisMatrixIsLinearInVelocity) {
  const State s = test_states(joints(), 18).back();
  const MatrixXd sum = coriolis_matrix(arm(), s.q, s.dq + s.ddq);
  const MatrixXd parts = coriolis_matrix(arm(), s.q, s.dq) + coriolis_matrix(arm(), s.q, s.ddq);
  EXPECT_TRUE(near(sum, parts, kRounding * (10 + sum.norm())));
}

TEST_P(OnEverySampleArm, TorqueIsTheSumOfItsParts) {
  for (const State& s : test_states(joints(), 19)) {
    const VectorXd parts = mass_matrix(arm(), s.q) * s.ddq +
                           coriolis_matrix(arm(), s.q, s.dq) * s.dq + gravity(arm(), s.q);
    const VectorXd tau = torques(arm(), s.q, s.dq, s.ddq);
    EXPECT_TRUE(near(tau, parts, kRounding * (10 + 10 * tau.norm())));
  }
}

TEST_P(OnEverySampleArm, ForwardDynamicsInvertInverseDynamics) {
  RigidBodyDynamics dynamics(arm(), phi());
  VectorXd tau(joints());
  VectorXd ddq(joints());
  for (const State& s : test_states(joints(), 20)) {
    dynamics.inverse_dynamics(s.q, s.dq, s.ddq, tau);
    ASSERT_TRUE(dynamics.forward_dynamics(s.q, s.dq, tau, ddq));
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(mass_matrix(arm(), s.q));
    EXPECT_TRUE(near(ddq, s.ddq, kRounding * (10 + tau.norm()) / eigen.eigenvalues()[0]));
  }
}

TEST(RigidBodyDynamics, ForwardDynamicsRefuseAnArmWithoutMass) {
  const Model arm = elbow_6r();
  const VectorXd zero = VectorXd::Zero(6);
  VectorXd ddq = zero;
  RigidBodyDynamics dynamics(arm, VectorXd::Zero(60));
  EXPECT_FALSE(dynamics.forward_dynamics(zero, zero, zero, ddq));
}

TEST(RigidBodyDynamics, WrongSizesAreNamed) {
  const Model arm = elbow_6r();
  const VectorXd six = VectorXd::Zero(6);
  const VectorXd five = VectorXd::Zero(5);
  EXPECT_THROW(RigidBodyDynamics(arm, six), InvalidInput);
  EXPECT_THROW(inverse_dynamics(arm, five, six, six), InvalidInput);
  EXPECT_THROW(inverse_dynamics(arm, six, five, six), InvalidInput);
  EXPECT_THROW(torque_regressor(arm, six, six, five), InvalidInput);
  EXPECT_THROW(mass_matrix(arm, five), InvalidInput);
  EXPECT_THROW(coriolis_matrix(arm, six, five), InvalidInput);
  try {
    torque_regressor(arm, six, five, six);
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_STREQ(error.what(),
                 "torque_regressor: dq has 5 entries, but arm 'elbow_6R' has 6 joints.");
  }
}

TEST(RigidBodyDynamics, AnArmWithoutValuesHasARegressorButNoTorques) {
  ArmBuilder builder("unknown", 1, 1);
  builder.link(-1, JointType::kRevolute, {1.0}, 0.0, identity_pose(), identity_pose());
  builder.description().frames.back().body->phi.reset();
  const Model arm = builder.build();
  const VectorXd zero = VectorXd::Zero(1);
  EXPECT_EQ(torque_regressor(arm, zero, zero, zero).cols(), kBodyParameters);
  EXPECT_THROW(inverse_dynamics(arm, zero, zero, zero), InvalidInput);
}

}  // namespace
}  // namespace veridyn
