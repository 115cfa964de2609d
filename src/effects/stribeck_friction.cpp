#include <cmath>

#include "effects/described_effect.hpp"
#include "registry.hpp"
#include "sliding_direction.hpp"

namespace veridyn {

/// Excess of static over Coulomb friction, which decays with speed:
///
///   tau = level * sign(ds) * exp(-(|ds| / velocity)^2)
///
/// with the sign of sliding_direction(). It always opposes the motion; where the total friction
/// falls with rising speed, a position loop may stick and slip. Source: Armstrong-Helouvry,
/// Dupont and Canudas de Wit, Automatica 30(7), 1994; thesis 5.6 and its reference [50].
const Effect& stribeck_friction() {
  EffectTraits t;
  t.role = EffectRole::kFriction;
  t.uses_velocity = true;
  t.dry = DryFriction::kVarying;
  t.slow = true;
  EffectShape velocity{"velocity", "rad/s", "m/s", 0.05, 5e-3, 1.0, true, true, 0.02};
  velocity.scale = ShapeScale::kSpeed;
  velocity.grid = {0.02, 0.06, 0.2};
  static const DescribedEffectInC kEffect({"stribeck_friction", {{"level", "N m", "N", ParameterSign::kNonnegative}}, {velocity}, t,
      [](const AxisSample& x, const ShapeValues& shape, EffectState&, EffectColumns& row) noexcept {
        const double ratio = x.ds / shape[0];
        row[0] = sliding_direction(x.ds) * std::exp(-ratio * ratio);
      },
      nullptr,
      [](const Effect& e, const std::vector<double>& values, const ShapeValues& shape, JointType type) {
        return parameter_text(e, values, 0, type) + " of extra friction near rest, gone above about " +
               text_with_unit(2.0 * shape[0], type == JointType::kPrismatic ? "m/s" : "rad/s");
      }},
      {"@direction(ds) * exp(-(ds / #0) * (ds / #0))"});
  return kEffect;
}

}  // namespace veridyn
