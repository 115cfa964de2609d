#include "math/clustered_statistics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "diagnosis/load_fit.hpp"
#include "math/median.hpp"
#include "support/near.hpp"

namespace veridyn {
namespace {

// The jackknife of a mean is its textbook standard error: the estimates without one of n values are
// (sum - x_k) / (n - 1), and their scatter times (n - 1) / n is s / sqrt(n).
TEST(Jackknife, OfAMeanEqualsItsStandardError) {
  std::mt19937 random(3);
  std::normal_distribution<double> gauss;
  const VectorXd x = VectorXd::NullaryExpr(12, [&] { return gauss(random); });
  MatrixXd without(1, 12);
  for (Eigen::Index k = 0; k < 12; ++k) without(0, k) = (x.sum() - x[k]) / 11.0;
  const double s = std::sqrt((x.array() - x.mean()).square().sum() / 11.0);
  EXPECT_NEAR(jackknife_deviations(without)[0], s / std::sqrt(12.0), 1e-12);
}

TEST(SolveScaled, SolvesRegularSystemsAndToleratesEqualColumns) {
  MatrixXd A(2, 2);
  A << 4.0, 1.0, 1.0, 3.0;
  const VectorXd b = VectorXd::LinSpaced(2, 1.0, 2.0);
  EXPECT_TRUE(near(A * VectorXd(solve_scaled(A, b)), b, 1e-9));
  MatrixXd twins = MatrixXd::Ones(2, 2);
  const VectorXd x = solve_scaled(twins, VectorXd::Ones(2));
  EXPECT_NEAR(x.sum(), 1.0, 1e-6);
}

// Units of the columns do not matter: kilograms or milligrams.
TEST(SolveScaled, IsIndifferentToTheUnitsOfColumns) {
  MatrixXd A(2, 2);
  A << 4.0, 1.0, 1.0, 3.0;
  const VectorXd b = VectorXd::LinSpaced(2, 1.0, 2.0);
  const VectorXd unit = (VectorXd(2) << 1.0, 1e9).finished();
  const MatrixXd scaled = unit.asDiagonal() * A * unit.asDiagonal();
  const VectorXd x = solve_scaled(scaled, VectorXd(unit.asDiagonal() * b));
  EXPECT_TRUE(near(unit.asDiagonal() * x, VectorXd(solve_scaled(A, b)), 1e-9));
}

TEST(Median, IsTheMiddleValue) {
  EXPECT_EQ(median(std::vector<double>{3.0, 1.0, 2.0}), 2.0);
  EXPECT_EQ(median(std::vector<double>{}), 0.0);
}

}  // namespace
}  // namespace veridyn
