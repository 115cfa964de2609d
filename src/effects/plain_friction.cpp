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

Model with_plain_friction(const Model& arm) {
  ModelDescription d = arm.description();
  for (int i = 0; i < arm.joints(); ++i) {
    const VectorXd axis = VectorXd::Unit(arm.joints(), i);
    for (const AxisEffect* effect : axis_effects()) {
      if (!effect->traits().elementary) continue;
      const bool known = std::any_of(d.effects.begin(), d.effects.end(), [&](const auto& term) {
        return term.effect == effect->name() && term.axis.coefficients == axis;
      });
      if (known) continue;
      EffectTerm term;
      term.effect = effect->name();
      term.axis = {axis, 0.0};
      d.effects.push_back(std::move(term));
    }
  }
  return Model(std::move(d));
}

}  // namespace veridyn
