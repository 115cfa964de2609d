#include "hide_and_seek/lagrange_arm.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "hide_and_seek/bench.hpp"
#include "support/near.hpp"
#include "support/random.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"

// Closed forms of the generator's dynamics, then comparison with the library's.

namespace veridyn::seek {
namespace {

// A point mass on a rod, hinged about a horizontal axis (y of the world).
LagrangeArm pendulum(double mass, double length) {
  Link hinge;
  hinge.name = "rod";
  hinge.ratios = VectorXd::Ones(1);
  hinge.has_body = true;
  hinge.a = length;
  hinge.moments = point_mass(mass, Vector3d::Zero());
  LagrangeArm arm;
  arm.joints = 1;
  arm.gravity = {0.0, -9.81, 0.0};
  arm.links = {hinge};
  return arm;
}

TEST(LagrangeArm, APendulumFollowsItsTextbookEquation) {
  const LagrangeArm arm = pendulum(0.7, 0.4);
  for (const double q : {0.0, 0.5, -2.0}) {
    const VectorXd tau = arm.torque(VectorXd::Constant(1, q), VectorXd::Constant(1, 1.3),
                                    VectorXd::Constant(1, -2.0));
    EXPECT_NEAR(tau[0], 0.7 * 0.4 * 0.4 * -2.0 + 0.7 * 9.81 * 0.4 * std::cos(q), 1e-8);
  }
}

// A mass on a turning rail: m r^2 ddq + 2 m r dr dq across, m (ddr - r dq^2) along.
TEST(LagrangeArm, ATurningRailHasCoriolisAndCentrifugalForces) {
  Link turn;
  turn.name = "turn";
  turn.alpha = -0.5 * M_PI;
  turn.ratios = VectorXd::Unit(2, 0);
  Link rail;
  rail.name = "rail";
  rail.parent = 0;
  rail.slides = true;
  rail.has_body = true;
  rail.ratios = VectorXd::Unit(2, 1);
  rail.moments = point_mass(1.5, Vector3d::Zero());
  LagrangeArm arm;
  arm.joints = 2;
  arm.gravity.setZero();
  arm.links = {turn, rail};
  const Eigen::Vector2d q(0.3, 0.6);
  const Eigen::Vector2d dq(1.1, -0.4);
  const Eigen::Vector2d ddq(0.7, 0.9);
  const VectorXd tau = arm.torque(q, dq, ddq);
  EXPECT_NEAR(tau[0], 1.5 * (0.6 * 0.6 * 0.7 + 2.0 * 0.6 * -0.4 * 1.1), 1e-8);
  EXPECT_NEAR(tau[1], 1.5 * (0.9 - 0.6 * 1.1 * 1.1), 1e-8);
}

/// m, h and the inertia about the origin, tr(S) 1 - S, of moments.
VectorXd inertial_values(const LagrangeArm& arm) {
  std::vector<double> phi;
  for (const Link& link : arm.links) {
    if (!link.has_body) continue;
    const Matrix4d& J = link.moments;
    const Eigen::Matrix3d S = J.topLeftCorner<3, 3>();
    const Eigen::Matrix3d L = S.trace() * Eigen::Matrix3d::Identity() - S;
    for (const double x :
         {J(3, 3), J(0, 3), J(1, 3), J(2, 3), L(0, 0), L(0, 1), L(1, 1), L(0, 2), L(1, 2), L(2, 2)})
      phi.push_back(x);
  }
  return Eigen::Map<VectorXd>(phi.data(), static_cast<Eigen::Index>(phi.size()));
}

class OnEveryBench : public testing::TestWithParam<std::string> {};

TEST_P(OnEveryBench, TheLibrarysTorquesAgreeToAMillionth) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    const Bench bench = make_bench(GetParam(), seed);
    RigidBodyDynamics engine(bench.robot, inertial_values(bench.arm));
    for (const veridyn::State& s : test_states(bench.arm.joints, seed)) {
      VectorXd expected(bench.arm.joints);
      engine.inverse_dynamics(s.q, s.dq, s.ddq, expected);
      EXPECT_TRUE(
          near(bench.arm.torque(s.q, s.dq, s.ddq), expected, 1e-6 * (1.0 + expected.norm())));
    }
  }
}

TEST_P(OnEveryBench, TheRegressorTimesTheMomentsIsTheTorque) {
  const Bench bench = make_bench(GetParam(), 4);
  std::vector<double> moments;
  for (const Link& link : bench.arm.links) {
    if (!link.has_body) continue;
    const Matrix4d& J = link.moments;
    for (const double x :
         {J(3, 3), J(0, 3), J(1, 3), J(2, 3), J(0, 0), J(0, 1), J(1, 1), J(0, 2), J(1, 2), J(2, 2)})
      moments.push_back(x);
  }
  const Eigen::Map<VectorXd> x(moments.data(), static_cast<Eigen::Index>(moments.size()));
  const veridyn::State s = test_states(bench.arm.joints, 4).back();
  const VectorXd tau = bench.arm.torque(s.q, s.dq, s.ddq);
  EXPECT_TRUE(near(bench.arm.regressor(s.q, s.dq, s.ddq) * x, tau, 1e-10 * (1.0 + tau.norm())));
}

TEST_P(OnEveryBench, BodiesArePhysicallyConsistent) {
  const Bench bench = make_bench(GetParam(), 5);
  for (const Link& link : bench.arm.links) {
    if (!link.has_body) continue;
    EXPECT_EQ(link.moments.llt().info(), Eigen::Success) << link.name;
  }
}

INSTANTIATE_TEST_SUITE_P(Arms, OnEveryBench, testing::ValuesIn(bench_arms()), [](const auto& arm) {
  std::string name = arm.param;
  for (char& c : name) c = c == '-' ? '_' : c;
  return name;
});

}  // namespace
}  // namespace veridyn::seek
