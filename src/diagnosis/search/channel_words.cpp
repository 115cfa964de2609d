#include "diagnosis/search/channel_words.hpp"

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

}  // namespace veridyn
