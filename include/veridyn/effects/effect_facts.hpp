#pragma once

#include <string>
#include <vector>

#include "veridyn/effects/effect.hpp"

namespace veridyn {

/// An effect along an axis of a model: its properties, units, names and values. Nothing here has a memory
/// that one sample leaves to the next; loops that need it take bound().
class EffectFacts : private BoundEffect {
 public:
  using BoundEffect::BoundEffect;  ///< (arm, term)
  using BoundEffect::effect;
  using BoundEffect::has_values;
  using BoundEffect::inertia;
  using BoundEffect::parameter_count;
  using BoundEffect::parameter_name;
  using BoundEffect::parameters;
  using BoundEffect::phrase;
  using BoundEffect::sample;
  using BoundEffect::shape;
  using BoundEffect::term;
  using BoundEffect::traits;
  using BoundEffect::unit;
  using BoundEffect::values;

  /// The names of all parameters.
  std::vector<std::string> parameter_names() const {
    std::vector<std::string> out;
    for (int p = 0; p < parameter_count(); ++p) out.push_back(parameter_name(p));
    return out;
  }

  /// The force along the axis with the values of the file, from an unloaded memory.
  double force_at(const AxisSample& sample) const noexcept {
    EffectColumns row{};
    EffectState state{};
    effect().columns(sample, shape(), state, row);
    double sum = 0.0;
    for (int p = 0; p < parameter_count(); ++p) sum += row[p] * values()[p];
    return sum;
  }

  /// The effect prepared for a loop, with an unloaded memory.
  const BoundEffect& bound() const { return *this; }
};

}  // namespace veridyn
