#include "effects/plain_friction.hpp"

#include <algorithm>

#include "veridyn/effects/effect.hpp"

namespace veridyn {

bool has_no_friction(const Model& arm) {
  return std::none_of(arm.effects().begin(), arm.effects().end(), [](const EffectTerm& term) {
    return has_effect(term.effect) &&
           find_effect(term.effect).traits().role == EffectRole::kFriction;
  });
}

namespace {

// Adds the effect without values along this coordinate alone (from 0), unless it is there.
void add_effect_to_joint(ModelDescription& d, const std::string& effect, int joint) {
  const VectorXd axis = VectorXd::Unit(static_cast<Eigen::Index>(d.coordinates.size()), joint);
  const bool known = std::any_of(d.effects.begin(), d.effects.end(), [&](const auto& term) {
    return term.effect == effect && term.axis.coefficients == axis;
  });
  if (known) return;
  EffectTerm term;
  term.effect = effect;
  term.axis = {axis, 0.0};
  d.effects.push_back(std::move(term));
}

}  // namespace

Model with_plain_friction(const Model& arm) {
  ModelDescription d = arm.description();
  for (int i = 0; i < arm.joints(); ++i) {
    for (const AxisEffect* effect : axis_effects()) {
      if (effect->traits().elementary) add_effect_to_joint(d, effect->name(), i);
    }
  }
  return Model(std::move(d));
}

Model with_effect_of_all_joints(const Model& arm, const std::string& effect) {
  ModelDescription d = arm.description();
  for (int i = 0; i < arm.joints(); ++i) add_effect_to_joint(d, effect, i);
  return Model(std::move(d));
}

}  // namespace veridyn
