#include "diagnosis/causes/effect_facts.hpp"

#include <algorithm>

#include "veridyn/effects/effect.hpp"
#include "veridyn/identification/arm_effects.hpp"

namespace veridyn {

bool is_friction(const std::string& effect) {
  return effect == "viscous_friction" || effect == "coulomb_friction";
}

bool is_channel(const Hypothesis& h) {
  return h.term >= 0 && is_arm_effect(h.effect);
}

std::string channel_phrase(const Model& arm, const EffectTerm& term,
                           const std::vector<double>& values) {
  return arm_effect_phrase(arm, term, values);
}

std::vector<std::string> elementary_effects() {
  return {"viscous_friction", "coulomb_friction", "torque_offset"};
}

bool asks_for_waves(const std::vector<std::string>& wanted) {
  return wanted.empty() ||
         std::find(wanted.begin(), wanted.end(), "torque_ripple") != wanted.end();
}

}  // namespace veridyn
