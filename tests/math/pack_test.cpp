#include "math/pack.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "support/random.hpp"

namespace veridyn {
namespace {

struct Baseline;
using P8 = Pack<8, Baseline>;
using P4 = Pack<4, Baseline>;

/// Distance in units in the last place of the exact value, which long double holds to 11 more bits.
double ulps(double got, long double exact) {
  const double nearest = std::abs(static_cast<double>(exact));
  const double ulp = std::nextafter(nearest, std::numeric_limits<double>::infinity()) - nearest;
  return static_cast<double>(std::abs(got - exact) / ulp);
}

template <typename P>
void expect_lanes_are_scalars() {
  Random random(1);
  P a(0.0);
  P b(0.0);
  for (int l = 0; l < P::kSize; ++l) {
    a.v[l] = random.in(-2, 2);
    b.v[l] = random.in(1, 2);
  }
  P more = a;
  more += b;
  P less = a;
  less -= b;
  for (int l = 0; l < P::kSize; ++l) {
    EXPECT_EQ((a + b).v[l], a.v[l] + b.v[l]);
    EXPECT_EQ((a - b).v[l], a.v[l] - b.v[l]);
    EXPECT_EQ((a * b).v[l], a.v[l] * b.v[l]);
    EXPECT_EQ((a / b).v[l], a.v[l] / b.v[l]);
    EXPECT_EQ((-a).v[l], -a.v[l]);
    EXPECT_EQ(more.v[l], a.v[l] + b.v[l]);
    EXPECT_EQ(less.v[l], a.v[l] - b.v[l]);
    EXPECT_EQ(P(3.0).v[l], 3.0);
  }
}

TEST(Pack, EveryLaneEqualsTheScalarResult) {
  expect_lanes_are_scalars<P4>();
  expect_lanes_are_scalars<P8>();
}

double worst_ulps(double x) {
  P8 s(0.0);
  P8 c(0.0);
  sine_cosine(P8(x), s, c);
  double worst = 0.0;
  for (int l = 0; l < P8::kSize; ++l) {
    worst = std::max({worst, ulps(s.v[l], std::sin(static_cast<long double>(x))),
                      ulps(c.v[l], std::cos(static_cast<long double>(x)))});
  }
  return worst;
}

TEST(Pack, SineAndCosineAreGoodToTwoUlp) {
  Random random(2);
  double worst = 0.0;
  for (int k = 0; k < 200000; ++k) worst = std::max(worst, worst_ulps(random.in(-100, 100)));
  EXPECT_LE(worst, 2.0);
}

// Where sine or cosine crosses zero the argument cancels; this is what the three-part pi/2 is for.
TEST(Pack, SineAndCosineAreGoodToTwoUlpNearMultiplesOfHalfPi) {
  double worst = 0.0;
  for (int k = -64; k <= 64; ++k) {
    double below = k * M_PI_2;
    double above = below;
    for (int step = 0; step < 50; ++step) {
      worst = std::max({worst, worst_ulps(below), worst_ulps(above)});
      below = std::nextafter(below, -1e3);
      above = std::nextafter(above, 1e3);
    }
  }
  EXPECT_LE(worst, 2.0);
}

TEST(Pack, SineAndCosineAreGoodToTwoUlpUpToAHundredThousand) {
  Random random(3);
  double worst = 0.0;
  for (int k = 0; k < 100000; ++k) worst = std::max(worst, worst_ulps(random.in(-1e5, 1e5)));
  EXPECT_LE(worst, 2.0);
}

TEST(Pack, SineOfTinyNumbersIsTheNumber) {
  for (const double x : {0.0, 1e-300, 1e-20, 1e-8}) EXPECT_LE(worst_ulps(x), 1.0) << x;
}

TEST(Pack, NanInOneLaneAffectsNoOtherLane) {
  P8 x(0.5);
  x.v[3] = std::numeric_limits<double>::quiet_NaN();
  P8 s(0.0);
  P8 c(0.0);
  sine_cosine(x, s, c);
  for (int l = 0; l < P8::kSize; ++l) EXPECT_EQ(std::isnan(s.v[l]), l == 3);
}

}  // namespace
}  // namespace veridyn
