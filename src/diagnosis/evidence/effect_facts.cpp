#include "diagnosis/evidence/effect_facts.hpp"

#include <algorithm>

#include "veridyn/effects/channel_effect.hpp"

namespace veridyn {

std::string channel_phrase(const Model& arm, const EffectTerm& term,
                           const std::vector<double>& values) {
  const bool slides = !term.axis.coefficients.isZero(0.0) && is_prismatic(arm, term.axis);
  std::string out = channel_effect(term.effect)
                        ->phrase(values, {}, slides ? JointType::kPrismatic : JointType::kRevolute);
  if (term.from) out += " of joint '" + axis_text(arm, *term.from) + "'";
  return out;
}

bool asks_for_waves(const std::vector<std::string>& wanted) {
  const auto is_wanted = [&wanted](const std::string& name) {
    return wanted.empty() || std::find(wanted.begin(), wanted.end(), name) != wanted.end();
  };
  for (const AxisEffect* effect : axis_effects()) {
    for (const EffectShape& shape : effect->shapes()) {
      if (shape.scale == ShapeScale::kWaves && is_wanted(effect->name())) return true;
    }
  }
  return false;
}

}  // namespace veridyn
