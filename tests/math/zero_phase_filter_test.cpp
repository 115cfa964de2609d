#include "math/zero_phase_filter.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/near.hpp"
#include "support/random.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

constexpr double kRate = 200.0;

// Response to a one in the middle of zeros, long enough to have died away on both sides.
VectorXd impulse_response(const ZeroPhaseFilter& filter) {
  const Eigen::Index half = 2 * filter.settling_samples(1e-14) + 20;
  MatrixXd x = MatrixXd::Zero(2 * half + 1, 1);
  x(half, 0) = 1.0;
  filter.apply(x);
  return x.col(0);
}

// Gain of both passes of a Butterworth low-pass by the bilinear transform, pre-warped at the
// cut-off.
double gain(double frequency, double cutoff, int order, double rate) {
  const double ratio = std::tan(M_PI * frequency / rate) / std::tan(M_PI * cutoff / rate);
  return 1.0 / (1.0 + std::pow(ratio, 2 * order));
}

// The filter's own gain: the Fourier sum of its impulse response about its middle. Imaginary part:
// any delay.
struct Response {
  double real = 0.0;
  double imaginary = 0.0;
};
Response response(const VectorXd& h, double frequency, double rate) {
  Response out;
  const auto half = (h.size() - 1) / 2;
  for (Eigen::Index k = 0; k < h.size(); ++k) {
    const double angle = 2.0 * M_PI * frequency / rate * static_cast<double>(k - half);
    out.real += h[k] * std::cos(angle);
    out.imaginary -= h[k] * std::sin(angle);
  }
  return out;
}

// Sections of order n round their gain by about n * eps / (1 - pole)^2, which is 1e-11 for the
// slowest here.
constexpr double kGainRounding = 1e-9;

TEST(TheZeroPhaseFilter, HasTheAnalyticGainOfTwoButterworthPasses) {
  for (int order = 1; order <= 20; ++order) {
    for (const double cutoff : {2.0, 5.0, 17.0, 50.0, 93.0}) {
      const VectorXd h = impulse_response(ZeroPhaseFilter(cutoff, order, kRate));
      for (const double f : {0.0, 0.3 * cutoff, 0.9 * cutoff, cutoff, 1.05 * cutoff, 60.0, 99.0}) {
        const Response r = response(h, f, kRate);
        EXPECT_NEAR(r.real, gain(f, cutoff, order, kRate), kGainRounding)
            << "order " << order << ", cut-off " << cutoff << ", at " << f;
        EXPECT_NEAR(r.imaginary, 0.0, kGainRounding)
            << "order " << order << ", cut-off " << cutoff << ", at " << f;
      }
    }
  }
}

// 3 dB per pass is half the power, and two passes are half the amplitude, whatever the order:
// cut-offs are in hertz of the -3 dB point and not of another convention.
TEST(TheZeroPhaseFilter, HalvesASineAtTheCutOffAndDoesNotShiftIt) {
  for (int order = 1; order <= 10; ++order) {
    for (const double rate : {50.0, 200.0, 1000.0}) {
      const double cutoff = 0.04 * rate;
      const Eigen::Index rows = 4000;
      MatrixXd x(rows, 1);
      for (Eigen::Index k = 0; k < rows; ++k)
        x(k, 0) = std::sin(2.0 * M_PI * cutoff / rate * static_cast<double>(k) + 0.4);
      const MatrixXd expected = 0.5 * x;
      ZeroPhaseFilter(cutoff, order, rate).apply(x);
      EXPECT_TRUE(near(x.middleRows(1000, 2000), expected.middleRows(1000, 2000), kGainRounding))
          << order << " at " << rate;
    }
  }
}

TEST(TheZeroPhaseFilter, HasASymmetricImpulseResponse) {
  for (int order = 1; order <= 10; ++order) {
    const VectorXd h = impulse_response(ZeroPhaseFilter(5.0, order, kRate));
    EXPECT_TRUE(near(h, h.reverse(), 1e-9 * h.maxCoeff())) << "order " << order;
    EXPECT_GE(h.maxCoeff(), 0.99 * h[(h.size() - 1) / 2]) << "order " << order;
  }
}

// The start-up settles to 1e-4 of its size over the reflected ends. What starts up is the lag of a
// pass on a line, which is order / (2 pi cutoff) or less times 1.5 [s].
TEST(TheZeroPhaseFilter, KeepsAStraightLineUpToItsEnds) {
  for (int order = 1; order <= 10; ++order) {
    for (const double cutoff : {2.0, 5.0, 20.0}) {
      const double slope = 3.0;
      MatrixXd x(1500, 2);
      for (Eigen::Index k = 0; k < x.rows(); ++k) {
        x(k, 0) = 7.0 + slope * static_cast<double>(k) / kRate;
        x(k, 1) = -5.0;
      }
      const MatrixXd line = x;
      ZeroPhaseFilter(cutoff, order, kRate).apply(x);
      const double lag = 1.5 * order / (2.0 * M_PI * cutoff);
      EXPECT_TRUE(near(x.col(0), line.col(0), 2e-4 * slope * lag))
          << "order " << order << ", cut-off " << cutoff;
      EXPECT_TRUE(near(x.col(1), line.col(1), 1e-10))
          << "a constant, order " << order << ", cut-off " << cutoff;
    }
  }
}

// The worst that samples of size one can do from so many samples away: the sum of the impulse
// response beyond.
TEST(TheZeroPhaseFilter, ResponseBeyondItsSettlingSamplesIsBelowTheRemainder) {
  for (int order = 1; order <= 10; ++order) {
    for (const double cutoff : {0.5, 2.0, 5.0, 20.0, 60.0}) {
      const ZeroPhaseFilter filter(cutoff, order, kRate);
      const VectorXd h = impulse_response(filter);
      const Eigen::Index half = (h.size() - 1) / 2;
      for (const double remainder : {1e-2, 1e-4, 1e-6, 1e-9}) {
        const Eigen::Index settled = filter.settling_samples(remainder);
        ASSERT_LT(settled, half);
        EXPECT_LE(h.tail(half - settled).cwiseAbs().sum(), remainder)
            << "order " << order << ", cut-off " << cutoff << ", " << remainder;
        // And not by waiting forever: half of it is not enough.
        EXPECT_GT(h.tail(half - settled / 4).cwiseAbs().sum(), remainder)
            << "order " << order << ", cut-off " << cutoff << ", " << remainder;
      }
    }
  }
}

TEST(TheZeroPhaseFilter, FiltersEveryColumnIndependently) {
  Random random(3);
  for (const int columns : {1, 7, 8, 9, 17}) {
    MatrixXd all(300, columns);
    for (int c = 0; c < columns; ++c) all.col(c) = random.vector(300, -1, 1);
    const ZeroPhaseFilter filter(8.0, 5, kRate);
    MatrixXd filtered = all;
    filter.apply(filtered);
    for (int c = 0; c < columns; ++c) {
      MatrixXd alone = all.col(c);
      filter.apply(alone);
      EXPECT_TRUE(near(filtered.col(c), alone, 0.0)) << "column " << c << " of " << columns;
    }
  }
}

TEST(TheZeroPhaseFilter, IsLinear) {
  Random random(4);
  const ZeroPhaseFilter filter(8.0, 6, kRate);
  const VectorXd a = random.vector(500, -1, 1);
  const VectorXd b = random.vector(500, -1, 1);
  MatrixXd x(500, 3);
  x << a, b, 2.0 * a - 3.0 * b;
  filter.apply(x);
  EXPECT_TRUE(near(x.col(2), 2.0 * x.col(0) - 3.0 * x.col(1), 1e-12));
}

TEST(TheZeroPhaseFilter, AcceptsRecordingsShorterThanItself) {
  for (const Eigen::Index rows : {0, 1, 2, 3, 10}) {
    MatrixXd x = MatrixXd::Constant(rows, 2, 4.0);
    ZeroPhaseFilter(2.0, 6, kRate).apply(x);
    EXPECT_TRUE(near(x, MatrixXd::Constant(rows, 2, 4.0), 1e-9)) << rows << " rows";
  }
}

TEST(TheZeroPhaseFilter, RefusesInvalidCutOffs) {
  EXPECT_NO_THROW(ZeroPhaseFilter(99.9, 1, kRate));
  EXPECT_NO_THROW(ZeroPhaseFilter(5.0, 20, kRate));
  EXPECT_THROW(ZeroPhaseFilter(0.0, 4, kRate), InvalidInput);
  EXPECT_THROW(ZeroPhaseFilter(-5.0, 4, kRate), InvalidInput);
  EXPECT_THROW(ZeroPhaseFilter(100.0, 4, kRate), InvalidInput);
  EXPECT_THROW(ZeroPhaseFilter(std::nan(""), 4, kRate), InvalidInput);
  EXPECT_THROW(ZeroPhaseFilter(5.0, 4, std::nan("")), InvalidInput);
  EXPECT_THROW(ZeroPhaseFilter(5.0, 4, -kRate), InvalidInput);
  EXPECT_THROW(ZeroPhaseFilter(5.0, 0, kRate), InvalidInput);
  EXPECT_THROW(ZeroPhaseFilter(5.0, 21, kRate), InvalidInput);
}

// ---- differentiate
// -------------------------------------------------------------------------------------------------

// Columns 1, t, t^2, t^3, t^4 and their derivatives.
struct Powers {
  MatrixXd values, derivatives;
};
Powers powers(Eigen::Index rows, double dt) {
  Powers p{MatrixXd(rows, 5), MatrixXd(rows, 5)};
  for (Eigen::Index i = 0; i < rows; ++i) {
    const double t = static_cast<double>(i) * dt - 0.3;
    for (int k = 0; k < 5; ++k) {
      p.values(i, k) = std::pow(t, k);
      p.derivatives(i, k) = k == 0 ? 0.0 : k * std::pow(t, k - 1);
    }
  }
  return p;
}

// Rounding of values of size one by differences over dt: 2 eps / dt.
TEST(Differentiate, IsExactOnCubicsAndQuartics) {
  const double dt = 0.01;
  const Powers p = powers(80, dt);
  const MatrixXd d = differentiate(p.values, dt);
  EXPECT_TRUE(near(d.middleRows(2, 76), p.derivatives.middleRows(2, 76), 1e-12));
}

TEST(Differentiate, FallsBackToLowerOrdersAtTheEnds) {
  const double dt = 0.01;
  for (const Eigen::Index rows : {2, 3, 4, 5, 9}) {
    const Powers p = powers(rows, dt);
    const MatrixXd d = differentiate(p.values, dt);
    EXPECT_TRUE(near(d.leftCols(2), p.derivatives.leftCols(2), 1e-12))
        << rows << " rows: lines are exact everywhere";
    if (rows < 3) continue;
    EXPECT_TRUE(near(d.middleRows(1, rows - 2).leftCols(3),
                     p.derivatives.middleRows(1, rows - 2).leftCols(3), 1e-12));
  }
  EXPECT_TRUE(near(differentiate(MatrixXd::Ones(1, 2), dt), MatrixXd::Zero(1, 2), 0.0));
}

// h^4 f'''''/30: halving the step divides the error by sixteen.
TEST(Differentiate, IsOfFourthOrder) {
  const auto worst = [](double dt) {
    const auto rows = static_cast<Eigen::Index>(1.0 / dt);
    MatrixXd x(rows, 1);
    VectorXd exact(rows);
    for (Eigen::Index i = 0; i < rows; ++i) {
      x(i, 0) = std::sin(7.0 * dt * static_cast<double>(i));
      exact[i] = 7.0 * std::cos(7.0 * dt * static_cast<double>(i));
    }
    return (differentiate(x, dt).col(0) - exact).segment(2, rows - 4).cwiseAbs().maxCoeff();
  };
  EXPECT_NEAR(worst(0.02), std::pow(7.0, 5) / 30.0 * std::pow(0.02, 4), 0.05 * worst(0.02));
  EXPECT_NEAR(worst(0.02) / worst(0.01), 16.0, 0.5);
}

}  // namespace
}  // namespace veridyn
