#include "diagnosis/evidence/clustered_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "math/median.hpp"
#include "support/near.hpp"
#include "math/student_t.hpp"

namespace veridyn {
namespace {

// The jackknife of a mean is its textbook standard error: the estimates without one of n values are
// (sum - x_k) / (n - 1), and their scatter times (n - 1) / n is s / sqrt(n).
TEST(Jackknife, OfAMeanIsItsStandardError) {
  std::mt19937 random(3);
  std::normal_distribution<double> gauss;
  const VectorXd x = VectorXd::NullaryExpr(12, [&] { return gauss(random); });
  MatrixXd without(1, 12);
  for (Eigen::Index k = 0; k < 12; ++k) without(0, k) = (x.sum() - x[k]) / 11.0;
  const double s = std::sqrt((x.array() - x.mean()).square().sum() / 11.0);
  EXPECT_NEAR(jackknife_deviations(without)[0], s / std::sqrt(12.0), 1e-12);
  EXPECT_NEAR(jackknife_covariance(without)(0, 0), s * s / 12.0, 1e-12);
}

// Of one parameter Hotelling's T2 is t squared, and F(1, g - 1) its distribution.
TEST(Wald, OfOneParameterIsStudentsTest) {
  MatrixXd without(1, 9);
  without << 1.0, 1.1, 0.9, 1.2, 0.8, 1.05, 0.95, 1.15, 0.85;
  const VectorXd x = VectorXd::Constant(1, 1.3);
  const double t = x[0] / jackknife_deviations(without)[0];
  EXPECT_NEAR(wald_p_value(x, without), student_t_two_sided(t, 8.0), 1e-6);
}

// Two parameters whose sum is certain and whose difference is not: each alone says little.
TEST(Wald, SeesASumOfWhichEachPartIsUncertain) {
  std::mt19937 random(5);
  std::normal_distribution<double> gauss;
  MatrixXd without(2, 40);
  for (Eigen::Index k = 0; k < 40; ++k) {
    const double difference = gauss(random);
    const double sum = 0.01 * gauss(random);
    without.col(k) << 1.0 + difference + sum, 1.0 - difference + sum;
  }
  const VectorXd x = VectorXd::Ones(2);
  EXPECT_GT(student_t_two_sided(1.0 / jackknife_deviations(without)[0], 39.0), 0.1);
  EXPECT_LT(wald_p_value(x, without), 1e-6);
}

TEST(RidgedSolver, SolvesWhatIsRegularAndSurvivesEqualColumns) {
  MatrixXd A(2, 2);
  A << 4.0, 1.0, 1.0, 3.0;
  const VectorXd b = VectorXd::LinSpaced(2, 1.0, 2.0);
  EXPECT_TRUE(near(A * VectorXd(RidgedSolver(A).solve(b)), b, 1e-9));
  MatrixXd twins = MatrixXd::Ones(2, 2);
  const VectorXd x = RidgedSolver(twins).solve(VectorXd::Ones(2));
  EXPECT_NEAR(x.sum(), 1.0, 1e-6);
}

// Units of the columns do not matter: kilograms or milligrams.
TEST(SolveScaled, IsIndifferentToTheUnitsOfColumns) {
  MatrixXd A(2, 2);
  A << 4.0, 1.0, 1.0, 3.0;
  const VectorXd b = VectorXd::LinSpaced(2, 1.0, 2.0);
  const VectorXd unit = (VectorXd(2) << 1.0, 1e9).finished();
  const MatrixXd scaled = unit.asDiagonal() * A * unit.asDiagonal();
  const VectorXd x = solve_scaled(scaled, unit.asDiagonal() * b);
  EXPECT_TRUE(near(unit.asDiagonal() * x, VectorXd(solve_scaled(A, b)), 1e-9));
}

TEST(Median, IsTheMiddleOne) {
  EXPECT_EQ(median(std::vector<double>{3.0, 1.0, 2.0}), 2.0);
  EXPECT_EQ(median(std::vector<double>{}), 0.0);
}

}  // namespace
}  // namespace veridyn
