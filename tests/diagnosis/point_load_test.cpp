#include "diagnosis/evidence/point_load.hpp"

#include <gtest/gtest.h>

#include <random>

#include "veridyn/model/model.hpp"

// Loads from a cost made of rows whose torques are known: tau = Y phi, cost = |tau - Y phi|^2 - |tau|^2.

namespace veridyn {
namespace {

using AboutCentre = Eigen::Matrix<double, 6, 1>;

MatrixXd rows(unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  MatrixXd Y(200, 10);
  for (double& entry : Y.reshaped()) entry = normal(random);
  return Y;
}

LoadCost cost_of(const MatrixXd& Y, const VectorXd& tau) {
  return {Y.transpose() * Y, Y.transpose() * tau};
}

TEST(PointLoads, AreFoundWhereTheyAre) {
  for (const double mass : {0.02, 1.0, 12.0}) {
    for (const Eigen::Vector3d& centre : {Eigen::Vector3d(0.1, -0.2, 0.3), Eigen::Vector3d(0.0, 0.0, 0.05), Eigen::Vector3d(0.0, 0.0, 0.0)}) {
      const VectorXd phi = inertial_parameters(mass, centre, AboutCentre::Zero());
      const MatrixXd Y = rows(3);
      const LoadCost f = cost_of(Y, Y * phi);
      const PointLoad found = fit_point_load(f, nullptr);
      EXPECT_NEAR(found.mass(), mass, 1e-5 * mass);
      EXPECT_LT((found.moment() - mass * centre).norm(), 1e-5 * mass);
      EXPECT_LT((found.phi - phi).norm(), 1e-5 * mass);
      EXPECT_NEAR(found.cost, -(Y * phi).squaredNorm(), 1e-8 * (Y * phi).squaredNorm());
      EXPECT_NEAR(found.cost, f.cost(found.phi), 1e-12 * std::abs(found.cost));
      EXPECT_LT(load_extent(f, found).norm(), 1e-4 * mass);
    }
  }
}

// What a body has about its centre comes on top of the point mass, and no load is better than none where nothing is.
TEST(PointLoads, HaveTheExtentThatABodyHasAboutItsCentre) {
  AboutCentre about_centre;
  about_centre << 0.02, 0.001, 0.03, -0.002, 0.003, 0.04;
  const MatrixXd Y = rows(4);
  const VectorXd body = inertial_parameters(2.0, {0.1, 0.2, -0.1}, about_centre);
  PointLoad at;
  at.phi = inertial_parameters(2.0, {0.1, 0.2, -0.1}, AboutCentre::Zero());
  EXPECT_LT((load_extent(cost_of(Y, Y * body), at) - about_centre).norm(), 1e-6);
  const PointLoad none = fit_point_load(cost_of(Y, VectorXd::Zero(Y.rows())), nullptr);
  EXPECT_EQ(none.mass(), 0.0);
  EXPECT_EQ(none.cost, 0.0);
}

// Joints about the vertical: neither the height nor any product with it is in a torque.
TEST(PointLoads, AreSeenAlongAxesThatTorquesKnow) {
  MatrixXd Y = rows(5);
  for (const int height : {3, 4, 6, 7, 8}) Y.col(height).setZero();
  const VectorXd phi = inertial_parameters(1.0, {0.1, 0.2, 0.3}, AboutCentre::Zero());
  PointLoad at;
  at.phi = phi;
  EXPECT_EQ(seen_directions(cost_of(Y, Y * phi), at), (std::array<bool, 3>{true, true, false}));
  EXPECT_EQ(seen_directions(cost_of(rows(5), rows(5) * phi), at), (std::array<bool, 3>{true, true, true}));
}

// A reach bounds the centre along each axis; the best load within it lies on the bound of the axis that is cut.
TEST(PointLoads, StayWithinTheirReach) {
  const MatrixXd Y = rows(6);
  const LoadCost f = cost_of(Y, Y * inertial_parameters(1.0, {0.05, 0.5, 0.0}, AboutCentre::Zero()));
  const PointLoad near = fit_point_load(f, nullptr, 0.2);
  EXPECT_LE(near.moment().cwiseAbs().maxCoeff(), 0.2 * near.mass() * (1.0 + 1e-12));
  EXPECT_NEAR(near.moment().y(), 0.2 * near.mass(), 1e-9);
  EXPECT_GT(near.cost, fit_point_load(f, nullptr).cost);
  EXPECT_LT(near.cost, 0.0);
}

// From a load nearby the descent ends in that minimum, and starts from many masses are all no better than the best.
TEST(PointLoads, TheBestOfAllStartsIsTheBest) {
  const MatrixXd Y = rows(7);
  std::mt19937 random(8);
  std::normal_distribution<double> noise(0.0, 0.3);
  VectorXd tau = Y * inertial_parameters(0.7, {0.1, 0.0, -0.2}, AboutCentre::Zero());
  for (double& entry : tau) entry += noise(random);
  const LoadCost f = cost_of(Y, tau);
  const PointLoad best = fit_point_load(f, nullptr);
  for (const PointLoad& one : all_point_loads(f, best.moment())) EXPECT_GE(one.cost, best.cost - 1e-9 * std::abs(best.cost));
  PointLoad aside = best;
  aside.phi.head<4>() *= 1.05;
  EXPECT_NEAR(fit_point_load(f, &aside).mass(), best.mass(), 1e-5);
  // At a minimum the slope is nothing, by differences of the cost along mass and moment.
  const auto at = [&](const Eigen::Vector4d& by) {
    const double mass = best.mass() + by[0];
    return f.cost(inertial_parameters(mass, (best.moment() + by.tail<3>()) / mass, AboutCentre::Zero()));
  };
  for (int k = 0; k < 4; ++k) {
    const double step = 1e-4;
    const double up = at(step * Eigen::Vector4d::Unit(k));
    const double down = at(-step * Eigen::Vector4d::Unit(k));
    EXPECT_GT(std::min(up, down), best.cost);
    EXPECT_LT(std::abs(up - down), 0.02 * (up + down - 2.0 * best.cost)) << k;
  }
}

}  // namespace
}  // namespace veridyn
