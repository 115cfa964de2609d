#include "simulation/rotors_at_zero.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "veridyn/effects/effect.hpp"

namespace veridyn {
namespace {

constexpr double kShare = 0.1;  // smallest inertia as a share of its standard deviation

}  // namespace

MovableArm with_movable_rotors(const Model& arm) {
  ModelDescription description = arm.description();
  std::vector<std::string> changed;
  for (EffectTerm& term : description.effects) {
    const AxisEffect& effect = find_axis_effect(term.effect);
    if (effect.traits().role != EffectRole::kInertia) continue;
    const std::string parameter = effect.parameters().front().name;
    const auto value = term.values.find(parameter);
    const auto deviation = term.deviations.find(parameter);
    if (value == term.values.end() || deviation == term.deviations.end() ||
        !std::isfinite(deviation->second))
      continue;
    const double least = kShare * deviation->second;
    if (value->second >= least) continue;
    changed.push_back(fmt::format(
        "{} on {} was identified as {:.2g} +- {:.2g}, at its bound; it gets {:.2g}", term.effect,
        axis_text(arm, term.axis), value->second, deviation->second, least));
    value->second = least;
  }
  return {Model(std::move(description)), changed};
}

}  // namespace veridyn
