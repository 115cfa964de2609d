#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "effects/effect_support.hpp"

// What an effect says of itself, against what its columns do.

namespace veridyn {
namespace {

struct Case {
  const AxisEffect* effect;
  ShapeValues shape;
  std::string label;
};

// Every effect with its initial constants, and again with each constant that is zero switched on:
// a distance, a slope, a lever.
std::vector<Case> cases() {
  std::vector<Case> out;
  for (const AxisEffect* effect : axis_effects()) {
    Case initial{effect, {}, effect->name()};
    const std::vector<EffectShape> shapes = effect->shapes();
    for (size_t i = 0; i < shapes.size(); ++i) initial.shape[i] = shapes[i].initial;
    out.push_back(initial);
    for (size_t i = 0; i < shapes.size(); ++i) {
      if (!shapes[i].logarithmic || shapes[i].initial != 0.0) continue;
      Case with = initial;
      for (size_t k = 0; k < shapes.size(); ++k) {
        if (shapes[k].logarithmic && shapes[k].initial == 0.0)
          with.shape[k] = std::sqrt(shapes[k].lower * shapes[k].upper);
      }
      with.label += "_with_" + shapes[i].name;
      out.push_back(with);
    }
  }
  return out;
}

class EveryEffect : public testing::TestWithParam<Case> {
 protected:
  EffectColumns columns(const AxisSample& x, EffectState& state) const {
    EffectColumns row{};
    GetParam().effect->columns(x, GetParam().shape, state, row);
    return row;
  }
  EffectColumns columns(const AxisSample& x) const {
    EffectState none{};
    return columns(x, none);
  }
  EffectTraits traits() const { return GetParam().effect->traits(GetParam().shape); }
  size_t count() const { return GetParam().effect->parameters().size(); }
};
INSTANTIATE_TEST_SUITE_P(Axis, EveryEffect, testing::ValuesIn(cases()),
                         [](const auto& test) { return test.param.label; });

// An input matters if, moved at any of many samples, it changes the columns or the state.
TEST_P(EveryEffect, ReadsOnlyDeclaredInputs) {
  std::map<std::string, double AxisSample::*> inputs{
      {"s", &AxisSample::s},       {"ds", &AxisSample::ds},
      {"dds", &AxisSample::dds},   {"from_s", &AxisSample::from_s},
      {"load", &AxisSample::load}, {"from_ds", &AxisSample::from_ds}};
  std::set<std::string> matters;
  EffectState state{};
  for (const AxisSample& x : random_samples(71)) {
    for (const auto& [name, input] : inputs) {
      AxisSample moved = x;
      moved.*input = -1.3 - 2.0 * x.*input;
      EffectState one = state;
      EffectState two = state;
      if (columns(x, one) != columns(moved, two) || one != two) matters.insert(name);
    }
    columns(x, state);
  }
  EXPECT_EQ(matters.count("s") > 0, traits().uses_position);
  EXPECT_EQ(matters.count("ds") > 0, traits().uses_velocity);
  EXPECT_EQ(matters.count("dds") > 0, traits().uses_acceleration);
  EXPECT_EQ(matters.count("load") > 0, traits().uses_load);
  EXPECT_EQ(matters.count("from_s") + matters.count("from_ds") > 0, traits().uses_source);
}

TEST_P(EveryEffect, HasAStateOnlyIfDeclaredWithMemory) {
  EffectState state{};
  for (const AxisSample& x : random_samples(72)) columns(x, state);
  EXPECT_EQ(state != EffectState{}, traits().memory);
}

// The four numbers of an affine force, asked at slow and fast, near and far samples.
TEST_P(EveryEffect, IsAffineIfDeclared) {
  if (traits().memory || traits().uses_load || traits().uses_source) {
    EXPECT_FALSE(traits().affine);
    return;
  }
  bool affine = true;
  for (size_t p = 0; p < count(); ++p) {
    const auto at = [&](double time, double s, double ds, double dds) {
      AxisSample x;
      x.time = time;
      x.s = s;
      x.ds = ds;
      x.dds = dds;
      return columns(x)[p];
    };
    const double constant = at(0, 0, 0, 0);
    for (const AxisSample& x : random_samples(73)) {
      const double expected = constant + (at(0, 1, 0, 0) - constant) * x.s +
                              (at(0, 0, 1, 0) - constant) * x.ds +
                              (at(0, 0, 0, 1) - constant) * x.dds;
      affine = affine &&
               std::abs(at(x.time, x.s, x.ds, x.dds) - expected) < 1e-12 * (1 + std::abs(expected));
    }
  }
  EXPECT_EQ(affine, traits().affine);
}

// Between minus and plus the rest speed dry friction is a straight line, beyond it bends off;
// constant where nothing but the direction counts.
TEST_P(EveryEffect, SaturatesAboveTheRestSpeedExactlyIfDeclaredDry) {
  bool dry = false;
  bool constant = true;
  for (size_t p = 0; p < count(); ++p) {
    const auto at = [&](double ds, double s, double load, double time) {
      AxisSample x;
      x.s = s;
      x.ds = ds;
      x.load = load;
      x.time = time;
      return columns(x)[p];
    };
    const auto slow = [&](double share) { return at(share * kRestSpeed, 0.3, 1.0, 1.0); };
    const double within = slow(1.0) - slow(0.5);
    dry = dry || std::abs(slow(1.5) - slow(1.0)) < 0.6 * std::abs(within);
    const double level = slow(1.0);
    constant = constant && at(0.7, 0.3, 1.0, 1.0) == level && at(-0.7, 0.3, 1.0, 1.0) == -level &&
               at(0.7, -0.8, 1.0, 1.0) == level && at(0.7, 0.3, 3.0, 1.0) == level &&
               at(0.7, 0.3, 1.0, 50.0) == level;
  }
  const DryFriction expected = !dry       ? DryFriction::kNone
                               : constant ? DryFriction::kConstant
                                          : DryFriction::kVarying;
  EXPECT_EQ(traits().dry, expected);
}

// Friction vanishes or opposes at rest and takes power out of a motion; a force at rest that
// depends on where the joint is, or is simply there, moves it.
TEST_P(EveryEffect, HasTorqueAtRestOnlyIfDeclared) {
  if (traits().memory || traits().depends_on_time) {
    EXPECT_FALSE(traits().holds_at_rest);
    return;
  }
  bool holds = false;
  for (const double s : {-0.6, 0.4, 1.1}) {
    AxisSample x;
    x.s = s;
    x.from_s = s;
    x.load = 1.0;
    const EffectColumns row = columns(x);
    for (size_t p = 0; p < count(); ++p) holds = holds || row[p] != 0.0;
  }
  EXPECT_EQ(holds, traits().holds_at_rest);
}

TEST_P(EveryEffect, DependsOnTimeOnlyIfDeclared) {
  if (traits().memory) return;  // differences of time are no time
  bool counts = false;
  for (AxisSample x : random_samples(74)) {
    const EffectColumns before = columns(x);
    x.time += 31.0;
    counts = counts || columns(x) != before;
  }
  EXPECT_EQ(counts, traits().depends_on_time);
}

// Friction takes power out whichever way the joint moves, where its parameters have the sign of
// nature; forces and inertia give back what they took.
TEST_P(EveryEffect, FrictionOpposesTheMotion) {
  if (traits().memory || !traits().forward_simulable) return;
  const std::vector<EffectParameter> parameters = GetParam().effect->parameters();
  for (const AxisSample& x : random_samples(75)) {
    const EffectColumns row = columns(x);
    AxisSample back = x;
    back.ds = -x.ds;
    const EffectColumns other = columns(back);
    for (size_t p = 0; p < count(); ++p) {
      const bool friction = traits().role == EffectRole::kFriction;
      if (friction && parameters[p].sign == ParameterSign::kNonnegative) {
        EXPECT_GE(row[p] * x.ds, 0.0) << parameters[p].name;
      } else if (!friction) {
        EXPECT_EQ(row[p], other[p]) << parameters[p].name;
      }
    }
  }
}

TEST_P(EveryEffect, ItsGridHasValuesForEverySearchedConstant) {
  AxisMotion motion;
  motion.middle = 0.2;
  motion.travel = 1.5;
  motion.speed = 2.0;
  motion.duration = 30.0;
  const std::vector<ShapeChoice> grid = GetParam().effect->grid(motion);
  EXPECT_EQ(grid.empty(), traits().tabulated);  // a table is what a residual looks like, and no guess
  for (const EffectShape& shape : GetParam().effect->shapes()) {
    std::set<double> values;
    for (const ShapeChoice& choice : grid) {
      if (choice.count(shape.name) > 0) values.insert(choice.at(shape.name));
    }
    EXPECT_TRUE(!shape.searched || !values.empty()) << shape.name;
    for (const double value : values)
      EXPECT_TRUE(value >= shape.lower && value <= shape.upper) << shape.name << " " << value;
  }
}

TEST(Traits, AFrictionEffectHasMemoryOnlyWithADistance) {
  for (const char* name : {"load_dependent_friction", "position_dependent_friction"}) {
    const AxisEffect& effect = find_axis_effect(name);
    ShapeValues shape{};
    EXPECT_FALSE(effect.traits(shape).memory) << name;
    for (size_t i = 0; i < effect.shapes().size(); ++i) {
      if (effect.shapes()[i].name == "distance") shape[i] = 0.01;
    }
    EXPECT_TRUE(effect.traits(shape).memory) << name;
    EXPECT_EQ(effect.traits(shape).dry, DryFriction::kNone) << name;
  }
}

TEST(Grid, ScalesWithTravelSpeedAndDurationOfTheMotion) {
  AxisMotion motion;
  motion.middle = 0.1;
  motion.travel = 2.0;
  motion.speed = 4.0;
  motion.duration = 100.0;
  const auto of = [&](const char* name) { return find_effect(name).grid(motion); };
  EXPECT_EQ(of("viscous_friction"), std::vector<ShapeChoice>{{}});
  EXPECT_EQ(
      of("stribeck_friction"),
      (std::vector<ShapeChoice>{{{"velocity", 0.08}}, {{"velocity", 0.24}}, {{"velocity", 0.8}}}));
  EXPECT_EQ(of("position_force"),
            (std::vector<ShapeChoice>{{{"centre", 0.1}, {"half_range", 1.0}}}));
  EXPECT_EQ(of("warm_up"), (std::vector<ShapeChoice>{{{"time_constant", 50.0}}}));
  motion.waves.emplace();
  EXPECT_TRUE(of("torque_ripple").empty());
  motion.waves = {30.0, 60.0};
  EXPECT_EQ(of("torque_ripple"), (std::vector<ShapeChoice>{{{"order", 30.0}}, {{"order", 60.0}}}));
}

}  // namespace
}  // namespace veridyn
