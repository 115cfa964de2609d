#include "veridyn/dynamics/equation_of_motion.hpp"

#include <gtest/gtest.h>

#include "support/near.hpp"
#include "support/sample_arms.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"

namespace veridyn {
namespace {

class EquationOfMotionOnEverySampleArm : public OnSampleArm {};
INSTANTIATE_TEST_SUITE_P(Sample, EquationOfMotionOnEverySampleArm,
                         testing::ValuesIn(sample_arm_names()), sample_arm_name);

// The mass matrix by body Jacobians and the bias by one recursion, against both from lanes of unit
// accelerations; the rest is rounding of the difference.
TEST_P(EquationOfMotionOnEverySampleArm, IsThatOfTheScalarRecursions) {
  RigidBodyDynamics scalar(arm(), phi());
  EquationOfMotion lanes(arm(), phi());
  const VectorXd zero = VectorXd::Zero(joints());
  VectorXd expected_h(joints());
  VectorXd h(joints());
  MatrixXd expected_M(joints(), joints());
  MatrixXd M(joints(), joints());
  for (const State& s : test_states(joints(), 47)) {
    scalar.inverse_dynamics(s.q, s.dq, zero, expected_h);
    scalar.mass_matrix(s.q, expected_M);
    lanes.evaluate(s.q, s.dq, M, h);
    const double size = 1.0 + expected_h.norm() + expected_M.norm();
    EXPECT_TRUE(near(h, expected_h, 1e-13 * size));
    EXPECT_TRUE(near(M, expected_M, 1e-13 * size));
  }
}

}  // namespace
}  // namespace veridyn
