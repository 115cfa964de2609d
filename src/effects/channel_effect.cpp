#include "veridyn/effects/channel_effect.hpp"

#include <utility>

#include "veridyn/math/require.hpp"

namespace veridyn {

std::vector<RigidColumn> ChannelEffect::rigid_columns(const Model& /*arm*/, int /*joint*/) const {
  return {};
}

std::string ChannelEffect::place(const Model& arm, const EffectTerm& term) const {
  return whole_arm() ? "arm" : axis_text(arm, term.axis);
}

Model with_channel_error(const Model& arm, const EffectTerm& term,
                         const std::vector<double>& values) {
  const ChannelEffect* effect = channel_effect(term.effect);
  require(effect != nullptr, "with_channel_error: '", term.effect, "' is not a channel error.");
  ModelDescription out = arm.description();
  effect->apply(out, effect->whole_arm() ? 0 : main_coordinate(term.axis), values);
  return Model(std::move(out));
}

}  // namespace veridyn
