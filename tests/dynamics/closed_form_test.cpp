#include <gtest/gtest.h>

#include <cmath>

#include "support/near.hpp"
#include "support/sample_arms.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"

namespace veridyn {
namespace {

constexpr double kGravity = 9.81;
constexpr double kRounding = 1e-13;  // a few hundred roundings of terms below 100

// tau = Lzz ddq + g (hx cos q - hy sin q)
TEST(Pendulum, TorqueIsTheClosedForm) {
  const Model arm = pendulum();
  const VectorXd phi = *arm.inertial_values();
  for (const State& s : test_states(1, 21)) {
    const double q = s.q[0];
    const double expected =
        phi[9] * s.ddq[0] + kGravity * (phi[1] * std::cos(q) - phi[2] * std::sin(q));
    EXPECT_NEAR(inverse_dynamics(arm, s.q, s.dq, s.ddq)[0], expected, 100 * kRounding);
    EXPECT_NEAR(mass_matrix(arm, s.q)(0, 0), phi[9], kRounding);
    EXPECT_NEAR(coriolis_matrix(arm, s.q, s.dq)(0, 0), 0.0, kRounding);
  }
}

TEST(Pendulum, RegressorIsTheClosedForm) {
  for (const State& s : test_states(1, 22)) {
    MatrixXd expected = MatrixXd::Zero(1, kBodyParameters);
    expected(0, 1) = kGravity * std::cos(s.q[0]);
    expected(0, 2) = -kGravity * std::sin(s.q[0]);
    expected(0, 9) = s.ddq[0];
    EXPECT_TRUE(near(torque_regressor(pendulum(), s.q, s.dq, s.ddq), expected, 100 * kRounding));
  }
}

// Lagrange's equations by hand. The second body's first moment enters through k(q2) = hx cos q2 -
// hy sin q2.
TEST(Planar2R, DynamicsAreTheClosedForm) {
  const Model arm = planar_2r();
  const VectorXd phi = *arm.inertial_values();
  const double l = kPlanarLength1;
  const double L1 = phi[9];
  const double m2 = phi[10];
  const double hx = phi[11];
  const double hy = phi[12];
  const double L2 = phi[19];
  for (const State& s : test_states(2, 23)) {
    const double q1 = s.q[0];
    const double q12 = s.q[0] + s.q[1];
    const double k = hx * std::cos(s.q[1]) - hy * std::sin(s.q[1]);
    const double dk = -hx * std::sin(s.q[1]) - hy * std::cos(s.q[1]);
    const double g2 = kGravity * (hx * std::cos(q12) - hy * std::sin(q12));
    const double g1 =
        kGravity * (phi[1] * std::cos(q1) - phi[2] * std::sin(q1) + m2 * l * std::cos(q1)) + g2;
    Eigen::Matrix2d M;
    M << L1 + m2 * l * l + L2 + 2 * l * k, L2 + l * k, L2 + l * k, L2;
    const double dq1 = s.dq[0];
    const double dq2 = s.dq[1];
    Eigen::Matrix2d C;  // the Christoffel symbols of M; dM/dt - 2 C is skew
    C << l * dk * dq2, l * dk * (dq1 + dq2), -l * dk * dq1, 0.0;
    const Eigen::Vector2d tau = M * s.ddq + C * s.dq + Eigen::Vector2d(g1, g2);
    EXPECT_TRUE(near(inverse_dynamics(arm, s.q, s.dq, s.ddq), tau, 100 * kRounding));
    EXPECT_TRUE(near(mass_matrix(arm, s.q), M, 10 * kRounding));
    EXPECT_TRUE(near(coriolis_matrix(arm, s.q, s.dq) * s.dq, C * s.dq, 10 * kRounding));
  }
}

// A mass that slides along z of the world: tau = m (ddq + g).
TEST(Slider, TorqueIsMassTimesAccelerationPlusGravity) {
  ArmBuilder builder("slider", 1, 24);
  builder.link(-1, JointType::kPrismatic, {1.0}, 0.0, identity_pose(), identity_pose());
  const Model arm = builder.build();
  const double mass = (*arm.inertial_values())[0];
  for (const State& s : test_states(1, 25)) {
    EXPECT_NEAR(inverse_dynamics(arm, s.q, s.dq, s.ddq)[0], mass * (s.ddq[0] + kGravity),
                100 * kRounding);
  }
}

}  // namespace
}  // namespace veridyn
