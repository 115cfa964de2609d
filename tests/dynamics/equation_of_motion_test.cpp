#include <gtest/gtest.h>

#include "support/near.hpp"
#include "support/sample_arms.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"

namespace veridyn {
namespace {

class EquationOfMotionOnEverySampleArm : public OnSampleArm {};
INSTANTIATE_TEST_SUITE_P(Sample, EquationOfMotionOnEverySampleArm,
                         testing::ValuesIn(all_arm_names()), sample_arm_name);

TEST_P(EquationOfMotionOnEverySampleArm, IsTheMassMatrixAndTheTorquesAtNoAcceleration) {
  RigidBodyDynamics scalar(arm(), phi());
  RigidBodyDynamics lanes(arm(), phi());
  const VectorXd zero = VectorXd::Zero(joints());
  VectorXd expected_h(joints());
  VectorXd h(joints());
  MatrixXd expected_M(joints(), joints());
  MatrixXd M(joints(), joints());
  for (const State& s : test_states(joints(), 47)) {
    scalar.inverse_dynamics(s.q, s.dq, zero, expected_h);
    scalar.mass_matrix(s.q, expected_M);
    lanes.equation_of_motion(s.q, s.dq, M, h);
    const double size = 1.0 + expected_h.norm() + expected_M.norm();
    EXPECT_TRUE(near(h, expected_h, 1e-13 * size));
    EXPECT_TRUE(near(M, expected_M, 1e-13 * size));
  }
}

// Against central differences. Velocity torques are quadratic, so that these are exact for D.
TEST_P(EquationOfMotionOnEverySampleArm, DerivativesMatchCentralDifferences) {
  RigidBodyDynamics scalar(arm(), phi());
  RigidBodyDynamics lanes(arm(), phi());
  const int n = joints();
  const VectorXd zero = VectorXd::Zero(n);
  Random random(71);
  VectorXd h(n), plain_h(n), change(n), up(n), down(n);
  MatrixXd M(n, n), plain_M(n, n), D(n, n);
  for (const State& s : test_states(n, 48)) {
    const VectorXd direction = random.vector(n, -1, 1);
    const VectorXd way = 1e-7 * direction;
    lanes.equation_of_motion(s.q, s.dq, plain_M, plain_h);
    lanes.equation_of_motion(s.q, s.dq, s.ddq, way, M, h, D, change);
    // The two are compiled apart and may round differently.
    EXPECT_TRUE(near(h, plain_h, 1e-13 * (1.0 + plain_h.norm())));
    EXPECT_TRUE(near(M, plain_M, 1e-13 * (1.0 + plain_M.norm())));
    const double size = 1.0 + h.norm() + M.norm() * (1.0 + s.ddq.norm());
    for (int j = 0; j < n; ++j) {
      scalar.inverse_dynamics(s.q, s.dq + VectorXd::Unit(n, j), zero, up);
      scalar.inverse_dynamics(s.q, s.dq - VectorXd::Unit(n, j), zero, down);
      EXPECT_TRUE(near(D.col(j), 0.5 * (up - down), 1e-12 * size)) << j;
    }
    const double step = 1e-5;
    scalar.inverse_dynamics(s.q + step * direction, s.dq, s.ddq, up);
    scalar.inverse_dynamics(s.q - step * direction, s.dq, s.ddq, down);
    EXPECT_TRUE(near(change, 1e-7 * (up - down) / (2.0 * step), 1e-12 * size));
    lanes.equation_of_motion(s.q, s.dq, s.ddq, zero, M, h, D, change);
    EXPECT_EQ(change, zero);
    lanes.equation_of_motion(s.q, s.dq, M, h, D);
    EXPECT_TRUE(near(h, plain_h, 1e-13 * (1.0 + plain_h.norm())));
  }
}

}  // namespace
}  // namespace veridyn
