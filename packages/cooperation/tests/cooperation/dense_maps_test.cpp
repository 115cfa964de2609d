#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "cooperation/stability/closed_loop.hpp"
#include "cooperation/stability/loop_search.hpp"
#include "support/near.hpp"
#include "support/random.hpp"

// The numbers under the linear loop, against closed forms.

namespace veridyn {
namespace {

// A damped oscillator over one cycle: exp(A t) and its integral, whatever the scale of time.
TEST(DenseMaps, AnOscillatorFollowsItsClosedForm) {
  for (const double t : {1e-4, 0.01, 1.0, 40.0}) {
    const double w0 = 3.0, decay = 0.4, w = std::sqrt(w0 * w0 - decay * decay);
    MatrixXd A(2, 2), B(2, 1), transition, input;
    A << 0.0, 1.0, -w0 * w0, -2.0 * decay;
    B << 0.0, 1.0;
    discretise(A, B, t, transition, input);
    const double e = std::exp(-decay * t), c = std::cos(w * t), s = std::sin(w * t);
    MatrixXd expected(2, 2);
    // clang-format off
    expected << e * (c + decay / w * s),     e * s / w,
                -e * w0 * w0 / w * s,        e * (c - decay / w * s);
    // clang-format on
    EXPECT_TRUE(near(transition, expected, 1e-12)) << t;
    // int exp(A t) B dt = A^-1 (exp(A t) - 1) B
    const MatrixXd integral = A.inverse() * (expected - MatrixXd::Identity(2, 2)) * B;
    EXPECT_TRUE(near(input, integral, 1e-12)) << t;
  }
}

// A double integrator has a singular A: position t^2 / 2, velocity t.
TEST(DenseMaps, ASingularSystemMatrixIsDiscretisedExactly) {
  MatrixXd A = MatrixXd::Zero(2, 2), transition, input;
  A(0, 1) = 1.0;
  discretise(A, Eigen::Vector2d(0.0, 1.0), 0.3, transition, input);
  EXPECT_TRUE(near(transition, (MatrixXd(2, 2) << 1.0, 0.3, 0.0, 1.0).finished(), 1e-15));
  EXPECT_TRUE(near(input, Eigen::Vector2d(0.045, 0.3), 1e-15));
}

// Similar matrices have the eigenvalues that they were made from, complex ones among them.
TEST(DenseMaps, TheSpectralRadiusIsTheLargestModulus) {
  Random random(3);
  for (int trial = 0; trial < 20; ++trial) {
    const double a = random.in(-0.9, 0.9), r = random.in(0.1, 1.5), turn = random.in(0.1, 3.0);
    MatrixXd D = MatrixXd::Zero(3, 3);
    D(0, 0) = a;
    D.bottomRightCorner(2, 2) << r * std::cos(turn), -r * std::sin(turn), r * std::sin(turn), r * std::cos(turn);
    const MatrixXd S = MatrixXd::Identity(3, 3) + 0.3 * MatrixXd(random.vector(9, -1.0, 1.0).reshaped(3, 3));
    const MatrixXd A = S * D * S.inverse();
    EXPECT_NEAR(spectral_radius(A), std::max(std::abs(a), r), 1e-9);
    double product = 1.0;
    for (const auto& [re, im] : eigenvalues(A)) product *= std::hypot(re, im);
    EXPECT_NEAR(product, std::abs(a) * r * r, 1e-9);
  }
  MatrixXd none = MatrixXd::Identity(2, 2);
  none(0, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(spectral_radius(none), std::numeric_limits<double>::infinity());
  EXPECT_TRUE(eigenvalues(none).empty());
}

// The first crossing, not a later one; the end where there is none.
TEST(LoopSearch, TheFirstRootOfAnIntervalIsFound) {
  const auto rises = [](double x) { return x / 7.3; };
  EXPECT_NEAR(first_crossing(rises, 1.0, 100.0, 20), 7.3, 7.3e-2);
  EXPECT_LE(rises(first_crossing(rises, 1.0, 100.0, 20)), kUnstable);
  EXPECT_EQ(first_crossing(rises, 1.0, 7.0, 20), 7.0);
  const auto swings_twice = [](double x) { return (x > 3.0 && x < 9.0) || x > 50.0 ? 1.5 : 0.5; };
  EXPECT_NEAR(first_crossing(swings_twice, 1.0, 100.0, 20), 3.0, 3e-2);
}

}  // namespace
}  // namespace veridyn
