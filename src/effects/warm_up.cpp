#include <cmath>

#include "effects/described_effect.hpp"
#include "registry.hpp"
#include "sliding_direction.hpp"

namespace veridyn {

/// Friction that decays as grease warms, counted from the start of the recording:
///
///   tau = (level * sign(ds) + viscosity * ds) * exp(-time / time_constant)
///
/// with the sign of sliding_direction(). The steady-state friction is coulomb_friction and
/// viscous_friction. It requires a recording that starts cold and lasts for a good part of the time
/// constant; after a warm start the identified levels are smaller.
const Effect& warm_up() {
  EffectTraits t;
  t.role = EffectRole::kFriction;
  t.uses_velocity = true;
  t.dry = DryFriction::kVarying;
  t.depends_on_time = true;
  EffectShape time_constant{"time_constant", "s", "s", 60.0, 5.0, 2000.0, true};
  time_constant.scale = ShapeScale::kDuration;
  time_constant.grid = {0.5};
  static const DescribedEffect kEffect({"warm_up", {{"level", "N m", "N", ParameterSign::kNonnegative}, {"viscosity", "N m s/rad", "N s/m", ParameterSign::kNonnegative}}, {time_constant}, t,
      [](const AxisSample& x, const ShapeValues& shape, EffectState&, EffectColumns& row) noexcept {
        const double cold = std::exp(-x.time / shape[0]);
        row[0] = sliding_direction(x.ds) * cold;
        row[1] = x.ds * cold;
      },
      "% of Coulomb and % of viscous friction that fade with a time constant of #"});
  return kEffect;
}

}  // namespace veridyn
