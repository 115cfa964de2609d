#include "veridyn/effects/channel_effect.hpp"

#include <utility>

#include "veridyn/math/require.hpp"

namespace veridyn {

std::vector<RigidColumn> ChannelEffect::rigid_columns(const Model& /*arm*/, int /*joint*/) const {
  return {};
}

std::string ChannelEffect::place(const Model& arm, const EffectTerm& term) const {
  const bool of_arm = whole_arm() || channel_joint(*this, term) == kAllJoints;
  return of_arm ? "arm" : axis_text(arm, term.axis);
}

int channel_joint(const ChannelEffect& effect, const EffectTerm& term) {
  if (effect.can_be_common() && term.axis.coefficients.isZero(0.0)) return kAllJoints;
  return main_coordinate(term.axis);
}

Model with_channel_error(const Model& arm, const EffectTerm& term,
                         const std::vector<double>& values) {
  const ChannelEffect* effect = channel_effect(term.effect);
  require(effect != nullptr, "with_channel_error: '", term.effect, "' is not a channel error.");
  ModelDescription out = arm.description();
  effect->apply(out, channel_joint(*effect, term), values);
  return Model(std::move(out));
}

}  // namespace veridyn
