#pragma once

#include <string>
#include <vector>

#include "veridyn/effects/effect.hpp"

namespace veridyn {

/// An effect along an axis of a model: its traits, units, parameter names and values. It has no state:
/// code that evaluates an effect sample by sample, with hysteresis or delays, uses bound().
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

  /// Force along the axis [N m] or [N] at one sample, with the values of the model and the initial state.
  double force_at(const AxisSample& sample) const noexcept {
    EffectColumns row{};
    EffectState state{};
    effect().columns(sample, shape(), state, row);
    double sum = 0.0;
    for (int p = 0; p < parameter_count(); ++p) sum += row[p] * values()[p];
    return sum;
  }

  /// This effect as a BoundEffect with its own state, initially unloaded, for evaluation sample by sample.
  const BoundEffect& bound() const { return *this; }
};

}  // namespace veridyn
