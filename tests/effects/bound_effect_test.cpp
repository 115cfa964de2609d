#include <gtest/gtest.h>

#include <cmath>

#include "effects/effect_support.hpp"
#include "support/malloc_count.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn {
namespace {

std::string message_of(const EffectTerm& term) {
  try {
    const BoundEffect e(bare_arm({}), term);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

class EveryBoundEffect : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Axis, EveryBoundEffect, testing::ValuesIn(axis_effect_names()),
                         effect_case);

std::map<std::string, double> random_values(const std::string& effect, Random& random) {
  std::map<std::string, double> values;
  for (const EffectParameter& p : find_effect(effect).parameters())
    values[p.name] = random.in(0.1, 2.0);
  return values;
}

// force(a v + b w) = a force(v) + b force(w), memory included.
TEST_P(EveryBoundEffect, TheForceIsLinearInTheParameters) {
  Random random(61);
  const std::map<std::string, double> v = random_values(GetParam(), random);
  const std::map<std::string, double> w = random_values(GetParam(), random);
  std::map<std::string, double> mixed;
  for (const auto& [name, value] : v) mixed[name] = 2.0 * value - 3.0 * w.at(name);
  BoundEffect force_v = bound(GetParam(), v);
  BoundEffect force_w = bound(GetParam(), w);
  BoundEffect force_mixed = bound(GetParam(), mixed);
  ASSERT_TRUE(force_mixed.has_values());
  for (const AxisSample& x : random_samples(62)) {
    const double a = force_v.force(x);
    const double b = force_w.force(x);
    EXPECT_NEAR(force_mixed.force(x), 2.0 * a - 3.0 * b, 1e-13 * (1 + std::abs(a) + std::abs(b)));
  }
}

TEST_P(EveryBoundEffect, NothingIsAllocatedAfterTheConstructor) {
  if (VERIDYN_COUNTS_MALLOC == 0) GTEST_SKIP() << "the sanitizer has a malloc of its own";
  const long at_start = malloc_count();
  BoundEffect e = bound(GetParam());
  ASSERT_GT(malloc_count(), at_start) << "the counter does not count";
  const std::vector<AxisSample> samples = random_samples(63);
  const State state = test_states(3, 64).back();
  EffectColumns row{};
  double sum = 0.0;
  const long before = malloc_count();
  for (const AxisSample& x : samples) {
    e.columns(x, row);
    sum += e.force(x);
  }
  sum += e.force(e.sample(1.0, state.q.data(), state.dq.data(), state.ddq.data(), 1));
  e.reset();
  EXPECT_EQ(malloc_count(), before);
  EXPECT_TRUE(std::isfinite(sum));
}

TEST_P(EveryBoundEffect, AnUnknownKeyIsRejectedWithTheKnownKeys) {
  EffectTerm term = term_of(GetParam(), yaw_axis(), {{"rubbish", 1.0}});
  term.where = "arm.yaml:12:5";
  const std::string message = message_of(term);
  EXPECT_EQ(message.rfind("arm.yaml:12:5: effect '" + GetParam() + "' has no 'rubbish'", 0), 0U)
      << message;
  for (const EffectParameter& p : find_effect(GetParam()).parameters()) {
    EXPECT_NE(message.find(p.name), std::string::npos) << message;
  }
  for (const EffectShape& s : find_effect(GetParam()).shapes()) {
    EXPECT_NE(message.find(s.name), std::string::npos) << message;
  }
}

TEST_P(EveryBoundEffect, AShapeConstantMustBeFiniteAndPositiveWhereItIsAScale) {
  for (const EffectShape& s : find_effect(GetParam()).shapes()) {
    EXPECT_NE(message_of(term_of(GetParam(), yaw_axis(), {{s.name, NAN}})), "") << s.name;
    const std::string message = message_of(term_of(GetParam(), yaw_axis(), {{s.name, -1.0}}));
    EXPECT_EQ(message.empty(), !s.logarithmic) << s.name << ": " << message;
  }
}

TEST(BoundEffect, ACouplingWithoutItsSourceIsRefused) {
  EffectTerm term = term_of("cable_coupling", yaw_axis());
  term.from.reset();
  EXPECT_NE(message_of(term).find("needs `from: {coordinate: 1}`"), std::string::npos);
}

TEST(BoundEffect, AnEffectThatActsOnNoAxisIsRefused) {
  EffectTerm term;
  term.effect = "payload";
  term.axis = yaw_axis();
  EXPECT_NE(message_of(term).find("'payload' cannot act along an axis"), std::string::npos);
}

TEST(BoundEffect, AnAxisIsALinearCombinationOfCoordinatesPlusAnOffset) {
  const Axis axis = axis_of(1.2, -0.8, 0.0, 0.3);
  const Model arm = bare_arm({});
  BoundEffect spring(arm, term_of("joint_spring", axis, {{"stiffness", 2.0}}));
  const double q[] = {0.5, 0.25, 9.0};
  const double dq[] = {1.0, 2.0, 9.0};
  const double ddq[] = {-1.0, 0.5, 9.0};
  const AxisSample x = spring.sample(4.0, q, dq, ddq, 1);
  EXPECT_DOUBLE_EQ(x.s, 1.2 * 0.5 - 0.8 * 0.25 + 0.3);
  EXPECT_DOUBLE_EQ(x.ds, 1.2 * 1.0 - 0.8 * 2.0);
  EXPECT_DOUBLE_EQ(x.dds, 1.2 * -1.0 - 0.8 * 0.5);
  EXPECT_DOUBLE_EQ(spring.force(x), 2.0 * x.s);
  EXPECT_EQ(spring.parameter_name(0), "joint_spring(1.2 yaw - 0.8 pitch + 0.3).stiffness");
  EXPECT_EQ(spring.unit(0), "N m/rad");
}

TEST(BoundEffect, SamplesAreReadWithAStrideAndTimeCountsFromTheReset) {
  // Three joints in columns of two samples; the second sample is wanted.
  const double q[] = {0, 0.1, 0, 0.2, 0, 0.3};
  const double dq[] = {0, 1.1, 0, 1.2, 0, 1.3};
  const double ddq[] = {0, 2.1, 0, 2.2, 0, 2.3};
  const Model arm = bare_arm({});
  EffectTerm term = term_of("cable_coupling", axis_of(0, 1, 0, 0));
  term.from = axis_of(-1, 0, 2, 0.5);
  BoundEffect e(arm, term);
  e.reset(1.6e9);
  const AxisSample x = e.sample(1.6e9 + 8.0, q + 1, dq + 1, ddq + 1, 2);
  EXPECT_EQ(x.time, 8.0);
  EXPECT_EQ(x.s, 0.2);
  EXPECT_EQ(x.ds, 1.2);
  EXPECT_EQ(x.dds, 2.2);
  EXPECT_DOUBLE_EQ(x.from_s, -0.1 + 0.6 + 0.5);
  EXPECT_DOUBLE_EQ(x.from_ds, -1.1 + 2.6);
}

TEST(BoundEffect, UnitsFollowTheJointTypesOfBothAxes) {
  const Model arm = bare_arm({});
  EffectTerm term = term_of("cable_coupling", yaw_axis());
  EXPECT_EQ(BoundEffect(arm, term).unit(0), "N m/m");
  EXPECT_EQ(BoundEffect(arm, term).unit(1), "N m/m^2");
  term.from = axis_of(0, 1, 0, 0);
  EXPECT_EQ(BoundEffect(arm, term).unit(0), "N m/rad");
  term.axis = insertion_axis();
  EXPECT_EQ(BoundEffect(arm, term).unit(1), "N/rad^2");
  EXPECT_EQ(BoundEffect(arm, term).unit(2), "N");
  EXPECT_EQ(BoundEffect(arm, term_of("rotor_inertia", insertion_axis())).unit(0), "kg");
}

TEST(BoundEffect, InitialShapeConstantsDependOnTheJointType) {
  const Model arm = bare_arm({});
  EXPECT_EQ(BoundEffect(arm, term_of("presliding_hysteresis", yaw_axis())).shape()[0], 5e-3);
  EXPECT_EQ(BoundEffect(arm, term_of("presliding_hysteresis", insertion_axis())).shape()[0],
            1.5e-4);
  EXPECT_EQ(
      BoundEffect(arm, term_of("presliding_hysteresis", insertion_axis(), {{"distance", 1e-3}}))
          .shape()[0],
      1e-3);
}

TEST(BoundEffect, HysteresesOnOneAxisHaveDistinctNames) {
  const EffectTerm near_one = term_of("presliding_hysteresis", yaw_axis(), {{"distance", 5e-3}});
  const EffectTerm far_one = term_of("presliding_hysteresis", yaw_axis(), {{"distance", 0.24}});
  EXPECT_EQ(BoundEffect(bare_arm({near_one}), near_one).parameter_name(0),
            "presliding_hysteresis(yaw).level");
  const Model arm = bare_arm({near_one, far_one});
  EXPECT_EQ(BoundEffect(arm, near_one).parameter_name(0),
            "presliding_hysteresis(yaw, distance 0.005).level");
  EXPECT_EQ(BoundEffect(arm, far_one).parameter_name(0),
            "presliding_hysteresis(yaw, distance 0.24).level");
}

TEST(BoundEffect, HasValuesOnlyIfTheFileGivesEveryParameter) {
  EXPECT_TRUE(bound("warm_up", {{"level", 0.2}, {"viscosity", 0.0}}).has_values());
  EXPECT_FALSE(bound("warm_up", {{"level", 0.2}, {"time_constant", 30.0}}).has_values());
}

TEST(BoundEffect, APhraseWithTooFewValuesIsRefused) {
  EXPECT_THROW(bound("warm_up").phrase({1.0}), InvalidInput);
}

}  // namespace
}  // namespace veridyn
