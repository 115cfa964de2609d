#pragma once

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "support/random.hpp"
#include "veridyn/effects/effect.hpp"

namespace veridyn {

/// Two revolute coordinates and a prismatic one, without any body.
inline Model bare_arm(const std::vector<EffectTerm>& effects) {
  constexpr double kFar = 1e3;
  const Limits limits{-kFar, kFar, kFar, kFar, kFar};
  ModelDescription d;
  d.name = "bare";
  d.coordinates = {{"yaw", limits, 0.0, false, {}},
                   {"pitch", limits, 0.0, false, {}},
                   {"insertion", limits, 0.0, true, {}}};
  Frame slide;
  slide.name = "slide";
  slide.type = JointType::kPrismatic;
  slide.variable.coefficients = Eigen::Vector3d(0, 0, 1);
  d.frames.push_back(slide);
  d.effects = effects;
  return Model(d);
}

inline Axis axis_of(double yaw, double pitch, double insertion, double offset) {
  return {Eigen::Vector3d(yaw, pitch, insertion), offset};
}

inline const Axis& yaw_axis() {
  static const Axis kAxis = axis_of(1, 0, 0, 0);
  return kAxis;
}

inline const Axis& insertion_axis() {
  static const Axis kAxis = axis_of(0, 0, 1, 0);
  return kAxis;
}

inline EffectTerm term_of(const std::string& effect, const Axis& axis,
                          std::map<std::string, double> values = {}) {
  EffectTerm term;
  term.effect = effect;
  term.axis = axis;
  if (find_effect(effect).traits().uses_source) term.from = insertion_axis();
  term.values = std::move(values);
  return term;
}

inline BoundEffect bound(const std::string& effect, std::map<std::string, double> values = {}) {
  const EffectTerm term = term_of(effect, yaw_axis(), std::move(values));
  return BoundEffect(bare_arm({}), term);
}

inline AxisSample moving(double s, double ds) {
  AxisSample x;
  x.s = s;
  x.ds = ds;
  return x;
}

/// The columns of an effect without memory, or at its first sample.
inline EffectColumns columns_of(const std::string& effect, const AxisSample& x,
                                std::map<std::string, double> shape = {}) {
  EffectColumns row{};
  bound(effect, std::move(shape)).columns(x, row);
  return row;
}

inline AxisSample random_sample(Random& random, double time) {
  AxisSample x;
  x.time = time;
  x.s = random.in(-2, 2);
  x.ds = random.in(-2, 2);
  x.dds = random.in(-5, 5);
  x.from_s = random.in(-1, 1);
  x.from_ds = random.in(-1, 1);
  x.load = random.in(-9, 9);
  return x;
}

/// At rest, all but at rest, and anywhere; in order of time.
inline std::vector<AxisSample> random_samples(unsigned seed) {
  Random random(seed);
  std::vector<AxisSample> samples{AxisSample{}};
  samples.push_back(moving(1e-8, -1e-8));
  samples.back().time = 0.005;
  for (int k = 2; k < 40; ++k) samples.push_back(random_sample(random, 0.005 * k));
  return samples;
}

inline std::vector<std::string> axis_effect_names() {
  std::vector<std::string> names;
  for (const AxisEffect* e : axis_effects()) names.push_back(e->name());
  return names;
}

inline std::string effect_case(const testing::TestParamInfo<std::string>& test) {
  return test.param;
}

}  // namespace veridyn
