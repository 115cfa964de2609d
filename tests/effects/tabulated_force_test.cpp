#include <gtest/gtest.h>

#include "effects/tabulated_force.hpp"
#include "veridyn/effects/effect.hpp"

// A table says what its values say: straight lines between them, constant outside, zero in the middle.

namespace veridyn {
namespace {

constexpr double kLow = -0.4;
constexpr double kHigh = 0.8;
constexpr double kMiddle = 0.2;

double force(const AxisSample& x, ShapeValues shape, double (*curve)(double)) {
  const AxisEffect& effect = find_axis_effect(kTabulatedForce);
  EffectState none{};
  EffectColumns row{};
  effect.columns(x, shape, none, row);
  double sum = 0.0;
  int column = 0;
  for (int k = 0; k < kTableNodes; ++k) {
    if (k != kTableNodes / 2)
      sum += row[column++] * (curve(table_node(kLow, kHigh, k)) - curve(kMiddle));
  }
  return sum;
}

double line(double x) {
  return 3.0 * x - 1.0;
}

TEST(TabulatedForce, ReproducesAStraightLineAndDoesNotGrowOutside) {
  const ShapeValues shape = {1.0, kLow, kHigh, 0.0, 0.0, 1.0};
  AxisSample x;
  for (x.s = -2.0; x.s < 3.0; x.s += 0.07) {
    const double inside = std::min(std::max(x.s, kLow), kHigh);
    EXPECT_NEAR(force(x, shape, line), line(inside) - line(kMiddle), 1e-12) << x.s;
  }
}

TEST(TabulatedForce, ReadsTheSelectedSignal) {
  AxisSample x;
  x.s = 0.1;
  x.ds = 0.3;
  x.load = 0.5;
  x.from_s = -0.2;
  x.from_ds = 0.7;
  const double at[] = {0.0, 0.1, 0.3, 0.5, 0.0, -0.2, 0.7};
  for (const int signal : {1, 2, 3, 5, 6}) {
    const ShapeValues shape = {static_cast<double>(signal), kLow, kHigh, 0.0, 0.0, 1.0};
    EXPECT_NEAR(force(x, shape, line), line(at[signal]) - line(kMiddle), 1e-12) << signal;
    const EffectTraits t = find_effect(kTabulatedForce).traits(shape);
    EXPECT_EQ(t.uses_source, signal > 4);
    EXPECT_EQ(t.uses_load, signal == 3);
  }
}

// Two windows on a direction, or triangles one width apart, add up to the table without a window.
TEST(TabulatedForce, OverlappingWindowsAddUpToTheTableWithoutWindow) {
  AxisSample x;
  x.s = 0.55;
  for (x.ds = -0.9; x.ds < 1.0; x.ds += 0.1) {
    const double whole = force(x, {1.0, kLow, kHigh, 0.0, 0.0, 1.0}, line);
    double sides = 0.0;
    for (const double at : {-1.0, 1.0}) sides += force(x, {1.0, kLow, kHigh, 4.0, at, 1.0}, line);
    EXPECT_NEAR(sides, whole, 1e-12);
    double parts = 0.0;
    for (const double at : {-1.0, -0.5, 0.0, 0.5, 1.0}) parts += force(x, {1.0, kLow, kHigh, 2.0, at, 0.5}, line);
    EXPECT_NEAR(parts, whole, 1e-12);
  }
}

}  // namespace
}  // namespace veridyn
