#include "veridyn/model/fixed_coordinates.hpp"

#include <gtest/gtest.h>

#include "support/random.hpp"
#include "support/sample_arms.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

class OnEverySampleArm : public testing::TestWithParam<std::string> {};

INSTANTIATE_TEST_SUITE_P(Arms, OnEverySampleArm, testing::ValuesIn(sample_arm_names()), sample_arm_name);

// A joint that rests at its place takes no part: the other joints' torques are those of the whole
// arm with this joint's velocity and acceleration at zero.
TEST_P(OnEverySampleArm, FixingAJointGivesTheTorquesOfTheArmWithThatJointAtRest) {
  const Model arm = sample_arms().at(GetParam());
  if (arm.joints() < 2 || !arm.inertial_values()) GTEST_SKIP() << "nothing to hold";
  Random random(7);
  for (int held = 0; held < arm.joints(); ++held) {
    const double place = random.in(-0.5, 0.5);
    const Model rest = with_fixed(arm, {{arm.coordinates()[held].name, place}});
    ASSERT_EQ(rest.joints(), arm.joints() - 1);
    RigidBodyDynamics whole(arm, *arm.inertial_values());
    RigidBodyDynamics part(rest, *rest.inertial_values());
    VectorXd q = random.vector(arm.joints(), -1, 1);
    VectorXd dq = random.vector(arm.joints(), -2, 2);
    VectorXd ddq = random.vector(arm.joints(), -5, 5);
    q[held] = place;
    dq[held] = ddq[held] = 0.0;
    const auto others = [held](const VectorXd& v) {
      VectorXd out(v.size() - 1);
      out << v.head(held), v.tail(v.size() - held - 1);
      return out;
    };
    VectorXd tau(arm.joints());
    VectorXd tau_rest(rest.joints());
    whole.inverse_dynamics(q, dq, ddq, tau);
    part.inverse_dynamics(others(q), others(dq), others(ddq), tau_rest);
    EXPECT_LE((others(tau) - tau_rest).norm(), 1e-12 * (1.0 + tau.norm())) << "held: " << held;
  }
}

TEST(AnArm, WithAllJointsFixedIsRefused) {
  const Model arm = planar_2r();
  std::map<std::string, double> all;
  for (const Coordinate& c : arm.coordinates()) all[c.name] = 0.0;
  EXPECT_THROW(with_fixed(arm, all), InvalidInput);
  EXPECT_THROW(with_fixed(arm, {{"finger", 0.0}}), InvalidInput);
}

}  // namespace
}  // namespace veridyn
