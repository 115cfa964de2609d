#include <gtest/gtest.h>

#include "support/malloc_count.hpp"
#include "support/sample_arms.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"

namespace veridyn {
namespace {

class AllocationOnEverySampleArm : public OnSampleArm {};
INSTANTIATE_TEST_SUITE_P(Sample, AllocationOnEverySampleArm, testing::ValuesIn(all_arm_names()),
                         sample_arm_name);

TEST_P(AllocationOnEverySampleArm, NothingIsAllocatedAfterTheConstructor) {
  if (VERIDYN_COUNTS_MALLOC == 0) GTEST_SKIP() << "the sanitizer has a malloc of its own";
  const long at_start = malloc_count();
  RigidBodyDynamics dynamics(arm(), phi());
  EXPECT_GT(malloc_count(), at_start) << "the counter does not count";

  const State s = test_states(joints(), 41).back();
  VectorXd tau(joints());
  VectorXd ddq(joints());
  MatrixXd M(joints(), joints());
  const long before = malloc_count();
  dynamics.inverse_dynamics(s.q, s.dq, s.ddq, tau);
  dynamics.gravity_torques(s.q, tau);
  dynamics.mass_matrix(s.q, M);
  dynamics.coriolis_matrix(s.q, s.dq, M);
  dynamics.lagrangian_gradient(s.q, s.dq, tau);
  const bool solved = dynamics.forward_dynamics(s.q, s.dq, tau, ddq);
  EXPECT_EQ(malloc_count(), before);
  EXPECT_TRUE(solved);
}

}  // namespace
}  // namespace veridyn
