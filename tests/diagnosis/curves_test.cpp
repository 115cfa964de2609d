#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "diagnosis/search/shape_words.hpp"
#include "diagnosis/search/tables.hpp"
#include "effects/tabulated_force.hpp"
#include "veridyn/effects/effect.hpp"
#include "veridyn/files/model_file.hpp"

// Curves without a name: their description, and tables over two signals.

namespace veridyn {
namespace {

MotionSignal own_signal(SignalKind kind) {
  MotionSignal s;
  s.kind = kind;
  s.joint = 0;
  s.unit = "rad";
  s.low = -1.0;
  s.high = 1.0;
  return s;
}

using OfOne = std::function<double(double)>;

// A curve of 41 points from `low` to 1, or one for each direction.
UnnamedShape curves(double low, const std::vector<OfOne>& sides) {
  UnnamedShape out;
  out.effort = "N m";
  out.on_sides = sides.size() > 1;
  for (size_t side = 0; side < sides.size(); ++side) {
    for (int k = 0; k <= 40; ++k) {
      CurvePoint p;
      p.at = {low + (1.0 - low) * k / 40};
      p.value = sides[side](p.at.front());
      if (out.on_sides) p.at.push_back(side == 0 ? -1.0 : 1.0);
      out.curve.push_back(std::move(p));
    }
  }
  return out;
}

std::string said(const OfOne& curve, double low = -1.0) {
  return shape_words(curves(low, {curve}), {own_signal(SignalKind::kPosition)});
}

std::string said_of_sides(const OfOne& back, const OfOne& forth) {
  return shape_words(curves(-1.0, {back, forth}), {own_signal(SignalKind::kPosition), own_signal(SignalKind::kVelocity)});
}

TEST(CurveWords, DistinguishHumpsFromMonotonicCurves) {
  EXPECT_EQ(said([](double x) { return std::exp(-8.0 * x * x); }).find("one hump, 1 N m from"), 0U);
  EXPECT_EQ(said([](double x) { return std::sin(4.0 * x); }).find("two humps, 2 N m from"), 0U);
  EXPECT_EQ(said([](double x) { return x * x; }, 0.0).find("rising, 1 N m from"), 0U);
  EXPECT_EQ(said([](double x) { return -std::exp(x); }).find("falling, "), 0U);
  EXPECT_EQ(said([](double) { return 0.3; }), "none");
  EXPECT_EQ(shape_words({}, {own_signal(SignalKind::kPosition)}), "");
}

// A square is flat at one end only.
TEST(CurveWords, SaturatingCurvesAreFlatAtBothEnds) {
  const auto saturates = [](const OfOne& curve, double low) { return said(curve, low).find("saturating") != std::string::npos; };
  EXPECT_TRUE(saturates([](double x) { return std::tanh(2.0 * x); }, -1.0));
  EXPECT_TRUE(saturates([](double x) { return std::sin(0.5 * M_PI * x); }, -1.0));
  EXPECT_FALSE(saturates([](double x) { return x * x; }, 0.0));
  EXPECT_FALSE(saturates([](double x) { return std::exp(x); }, -1.0));
}

TEST(CurveWords, DescribeTheDifferenceOfTheDirections) {
  const OfOne rises = [](double x) { return std::exp(x); };
  const OfOne falls = [](double x) { return -std::exp(x); };
  const OfOne nothing = [](double) { return 0.0; };
  EXPECT_EQ(said_of_sides(falls, rises).find("with the sign of the direction: "), 0U);
  EXPECT_EQ(said_of_sides(rises, rises).find("the same in both directions: rising"), 0U);
  EXPECT_EQ(said_of_sides(nothing, rises).find("another one in each direction: rising"), 0U);
  EXPECT_EQ(said_of_sides(falls, nothing).find("another one in each direction: falling"), 0U);
}

// A surface over two positions, on the inner part of their ranges, where most of the rows are.
constexpr double kInner = 0.4;

UnnamedShape surface(double (*value)(double, double)) {
  UnnamedShape out;
  out.effort = "N m";
  for (int l = 0; l < 9; ++l) {
    for (int k = 0; k < 9; ++k) {
      CurvePoint p;
      p.at = {kInner * (k - 4) / 4, kInner * (l - 4) / 4};
      p.value = value(p.at[0], p.at[1]);
      out.curve.push_back(std::move(p));
    }
  }
  return out;
}

TEST(CurveTables, OfTwoPositionsReproduceTheSurface) {
  const Model arm = read_model("planar-2r");
  const auto value = [](double a, double b) { return 2.0 * a + 3.0 * b + 5.0 * a * b; };
  MotionSignal other = own_signal(SignalKind::kPosition);
  other.joint = 1;
  const std::vector<EffectTerm> terms = tables_of(arm, {0}, surface(value), {own_signal(SignalKind::kPosition), other});
  ASSERT_FALSE(terms.empty());
  const auto force = [&](double a, double b) {
    double sum = 0.0;
    for (const EffectTerm& term : terms) {
      AxisSample x;
      x.s = a;
      x.from_s = b;
      sum += BoundEffect(arm, term).force(x);
    }
    return sum;
  };
  const double node = table_node(-1.0, 1.0, 7);  // what lies between two of them is interpolated
  for (const double a : {-2.0 * node, -node, 0.0, node, 2.0 * node}) {
    for (const double b : {-2.0 * node, -node, 0.0, node, 2.0 * node}) EXPECT_NEAR(force(a, b) - force(0.0, 0.0), value(a, b), 1e-9) << a << " " << b;
  }
  EXPECT_EQ(shape_words(surface(value), {own_signal(SignalKind::kPosition), other}).find("a function of both, "), 0U);
}

TEST(CurveTables, WithADirectionHaveOneCurveForEachDirection) {
  const Model arm = read_model("planar-2r");
  const UnnamedShape shape = curves(-1.0, {[](double x) { return -x; }, [](double x) { return 3.0 * x; }});
  const std::vector<EffectTerm> terms =
      tables_of(arm, {0}, shape, {own_signal(SignalKind::kPosition), own_signal(SignalKind::kVelocity)});
  ASSERT_EQ(terms.size(), 2U);
  for (const double speed : {-0.5, 0.5}) {
    AxisSample x;
    x.s = 0.5;
    x.ds = speed;
    double sum = 0.0;
    for (const EffectTerm& term : terms) sum += BoundEffect(arm, term).force(x);
    EXPECT_NEAR(sum, speed < 0.0 ? -0.5 : 1.5, 1e-6);
  }
}

// A table has at most one other joint, and neither history nor time.
TEST(CurveTables, ExistOnlyForSignalsOfATabulatedForce) {
  const Model arm = read_model("psm-3dof");
  const UnnamedShape shape = surface([](double a, double b) { return a * b; });
  MotionSignal second = own_signal(SignalKind::kPosition), third = second;
  second.joint = 1;
  third.joint = 2;
  EXPECT_FALSE(tables_of(arm, {0}, shape, {own_signal(SignalKind::kPosition), third}).empty());
  EXPECT_TRUE(tables_of(arm, {0}, shape, {second, third}).empty());
  EXPECT_TRUE(tables_of(arm, {0}, shape, {own_signal(SignalKind::kPosition), own_signal(SignalKind::kHistory)}).empty());
  EXPECT_TRUE(tables_of(arm, {0}, shape, {}).empty());
}

}  // namespace
}  // namespace veridyn
