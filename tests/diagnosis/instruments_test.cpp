#include "diagnosis/preparation/instruments.hpp"

#include <gtest/gtest.h>

#include <random>

// Two columns; the second is measured with noise, in both repeats, independently.

namespace veridyn {
namespace {

constexpr int kRows = 4000;
constexpr double kFirst = 2.0, kSecond = -1.0;

RepeatedRows rows(double noise_in_column, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> gauss;
  RepeatedRows out;
  out.A.resize(kRows, 2);
  out.Z.resize(kRows, 2);
  out.b.resize(kRows);
  for (Eigen::Index r = 0; r < kRows; ++r) {
    const double first = gauss(random);
    const double second = gauss(random);
    out.A.row(r) << first, second + noise_in_column * gauss(random);
    out.Z.row(r) << first, second + noise_in_column * gauss(random);
    out.b[r] = kFirst * first + kSecond * second + 0.3 * gauss(random);
    out.cluster.push_back(static_cast<int>(16 * r / kRows));
  }
  return out;
}

// Noise of half the column's size attenuates by 1 / (1 + 0.25).
TEST(Instruments, RemoveTheAttenuationByNoiseInAColumn) {
  const InstrumentalEstimate e = compare_with_instruments({rows(0.5, 1)}, VectorXd::Ones(1));
  EXPECT_NEAR(e.least_squares[1], kSecond / 1.25, 0.03);
  EXPECT_NEAR(e.instrumental[1], kSecond, 0.04);
  EXPECT_NEAR(e.instrumental[0], kFirst, 0.03);
  EXPECT_LT(e.p_value[1], 1e-6);
  EXPECT_GT(e.p_value[0], 1e-3);
}

// The level of the test is 5 %.
TEST(Instruments, AgreeWithLeastSquaresWhereColumnsAreExact) {
  int rejected = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    RepeatedRows r = rows(0.0, seed);
    std::mt19937 random(seed + 100);
    std::normal_distribution<double> gauss;
    // The other repeat deviates as a controller does: still a valid instrument.
    for (double& z : r.Z.reshaped()) z += 0.2 * gauss(random);
    const InstrumentalEstimate e = compare_with_instruments({r}, VectorXd::Ones(1));
    rejected += static_cast<int>(e.p_value.minCoeff() < 0.025);
    EXPECT_NEAR(e.instrumental[0], e.least_squares[0], 0.02);
  }
  EXPECT_LE(rejected, 4);
}

}  // namespace
}  // namespace veridyn
