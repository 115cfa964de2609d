#pragma once

#include <string>
#include <utility>
#include <vector>

#include "support/near.hpp"
#include "support/sample_arms.hpp"
#include "veridyn/control/arm_state.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

inline std::string last_frame(const Model& arm) {
  return arm.frames().back().name;
}

inline EffectTerm effect_on(const Model& arm, const std::string& name, int joint,
                            std::map<std::string, double> values) {
  EffectTerm term;
  term.effect = name;
  term.axis.coefficients = VectorXd::Unit(arm.joints(), joint);
  term.values = std::move(values);
  return term;
}

inline Model with_effects(const Model& arm, std::vector<EffectTerm> effects) {
  ModelDescription description = arm.description();
  description.effects = std::move(effects);
  return Model(std::move(description));
}

}  // namespace veridyn
