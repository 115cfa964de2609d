#include "veridyn/identification/pseudo_inertia.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>
#include <random>

#include "identification/random_bodies.hpp"

namespace veridyn {
namespace {

using Eigen::Matrix4d;

TEST(PseudoInertia, OfAPointMassIsItsOuterProduct) {
  // m = 2 at (1, 2, 3): I = m*(r.r*1 - r*r').
  InertialVector phi;
  phi << 2.0, 2.0, 4.0, 6.0, 26.0, -4.0, 20.0, -6.0, -12.0, 10.0;
  const Eigen::Vector4d r(1.0, 2.0, 3.0, 1.0);
  EXPECT_LT((pseudo_inertia(phi) - 2.0 * r * r.transpose()).norm(), 1e-13);
  EXPECT_NEAR(smallest_eigenvalue(pseudo_inertia(phi)), 0.0, 1e-13);
}

TEST(PseudoInertia, AdjointAndInverseMatchTheMap) {
  std::mt19937 generator(5);
  const InertialVector phi = random_matrix(10, 1, generator);
  const Matrix4d Z = random_matrix(4, 4, generator);
  EXPECT_NEAR(pseudo_inertia(phi).cwiseProduct(Z).sum(), phi.dot(pseudo_inertia_adjoint(Z)), 1e-13);
  EXPECT_LT((inertial_parameters(pseudo_inertia(phi)) - phi).norm(), 1e-13);
}

TEST(PseudoInertia, EntropicDivergenceIsZeroAtThePriorAndAffineInvariant) {
  std::mt19937 generator(6);
  const Matrix4d J = pseudo_inertia(random_body(generator));
  const Matrix4d J0 = pseudo_inertia(random_body(generator));
  EXPECT_NEAR(entropic_divergence(J, J), 0.0, 1e-10);
  EXPECT_GT(entropic_divergence(J, J0), 0.0);
  const Matrix4d T = random_matrix(4, 4, generator);
  const double moved = entropic_divergence(T * J * T.transpose(), T * J0 * T.transpose());
  EXPECT_NEAR(moved, entropic_divergence(J, J0), 1e-8 * moved);
  EXPECT_EQ(entropic_divergence(-J, J0), std::numeric_limits<double>::infinity());
  EXPECT_EQ(entropic_divergence(J, -J0), std::numeric_limits<double>::infinity());
}

// A point mass gets a radius in every direction, a body with more than that stays, and no mass is no body.
TEST(PseudoInertia, APointMassGetsASizeAndALargerBodyIsUnchanged) {
  InertialVector point;
  point << 2.0, 2.0, 4.0, 6.0, 26.0, -4.0, 20.0, -6.0, -12.0, 10.0;  // 2 kg at (1, 2, 3)
  const InertialVector ball = with_minimum_radius(point, 0.1);
  EXPECT_EQ(ball.head<4>(), point.head<4>());
  // Second moments of 2 kg * (0.1 m)^2 along each axis: twice that as every moment of inertia.
  EXPECT_LT((ball - point - 0.04 * (InertialVector::Unit(4) + InertialVector::Unit(6) + InertialVector::Unit(9))).norm(), 1e-10);
  EXPECT_EQ(with_minimum_radius(ball, 0.05), ball);
  InertialVector none = point;
  none[0] = 0.0;
  EXPECT_TRUE(with_minimum_radius(none, 0.1).isZero(0.0));
  none[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(with_minimum_radius(none, 0.1).isZero(0.0));
  EXPECT_EQ(smallest_scaled_eigenvalue(-pseudo_inertia(ball)), -std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace veridyn
