#include "math/dual.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace veridyn {
namespace {

using D1 = Dual<double>;
using D2 = Dual<D1>;

constexpr double kRounding = 1e-14;

// f(x) = (x^2 - 3) sin x / (2 + cos x) - x
template <typename S>
S f(const S& x) {
  S s{};
  S c{};
  sine_cosine(x, s, c);
  S y = (x * x - S(3.0)) * s / (S(2.0) + c);
  y -= x;
  return y;
}

double df(double x) {
  const double s = std::sin(x);
  const double c = std::cos(x);
  const double d = 2 + c;
  return (2 * x * s + (x * x - 3) * c) / d + (x * x - 3) * s * s / (d * d) - 1;
}

TEST(Dual, EvaluatesTheFirstDerivative) {
  for (const double x : {-2.0, 0.0, 1e-8, 0.4, 3.0}) {
    const D1 y = f(D1(x, 1.0));
    EXPECT_NEAR(y.value, f(x), kRounding);
    EXPECT_NEAR(y.derivative, df(x), 10 * kRounding);
  }
}

TEST(Dual, IsLinearInItsDirection) {
  EXPECT_NEAR(f(D1(0.4, -2.5)).derivative, -2.5 * df(0.4), 10 * kRounding);
  EXPECT_EQ(f(D1(0.4)).derivative, 0.0);
}

// d2/dx2 of sin is -sin, of 1/x is 2/x^3, of x^3 is 6 x.
TEST(Dual, NestedEvaluatesTheSecondDerivative) {
  const double x = 0.7;
  const D2 X(D1(x, 1.0), D1(1.0));
  D2 s;
  D2 c;
  sine_cosine(X, s, c);
  EXPECT_NEAR(s.derivative.derivative, -std::sin(x), kRounding);
  EXPECT_NEAR(c.derivative.derivative, -std::cos(x), kRounding);
  EXPECT_NEAR((D2(1.0) / X).derivative.derivative, 2 / (x * x * x), 10 * kRounding);
  EXPECT_NEAR((X * X * X).derivative.derivative, 6 * x, 10 * kRounding);
  EXPECT_NEAR((-X).derivative.value, -1.0, 0.0);
  // The derivative of the derivative: a nested dual against the difference of plain ones.
  EXPECT_NEAR(f(X).derivative.derivative, (df(x + 1e-5) - df(x - 1e-5)) / 2e-5, 1e-9);
}

TEST(Dual, MixedPartialsAreThoseOfTheProduct) {
  // g(x, y) = x^2 y: d2g/dxdy = 2 x
  const D2 x(D1(1.5, 1.0), D1(0.0));
  const D2 y(D1(-2.0, 0.0), D1(1.0));
  EXPECT_NEAR((x * x * y).derivative.derivative, 3.0, kRounding);
}

}  // namespace
}  // namespace veridyn
