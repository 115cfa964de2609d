#include <cmath>

#include "effects/described_effect.hpp"
#include "registry.hpp"
#include "sliding_direction.hpp"

namespace veridyn {

/// Friction that differs between the two directions; each parameter is the forward minus the
/// backward value:
///
///   tau = level_difference * |sign(ds)| / 2 + viscous_difference * |ds| / 2
///
/// with the sign of sliding_direction(). The mean of both directions is coulomb_friction and
/// viscous_friction.
///
/// Identifiability: |ds| is a column of its own. |sign(ds)| is 1 whenever the joint moves, a
/// constant, and so confounded with torque_offset; only samples at rest, where it is 0, separate
/// the two. Recordings without rest determine only their sum, offset + level_difference / 2.
/// Source: thesis (4.13) and its errata.
const Effect& asymmetric_friction() {
  EffectTraits t;
  t.role = EffectRole::kFriction;
  t.uses_velocity = true;
  t.dry = DryFriction::kVarying;
  static const DescribedEffectInC kEffect({"asymmetric_friction", {{"level_difference", "N m", "N"}, {"viscous_difference", "N m s/rad", "N s/m"}}, {}, t,
      [](const AxisSample& x, const ShapeValues&, EffectState&, EffectColumns& row) noexcept {
        row[0] = 0.5 * std::abs(sliding_direction(x.ds));
        row[1] = 0.5 * std::abs(x.ds);
      },
      "friction that differs by direction, forwards minus backwards: % and %"},
      {"0.5 * fabs(@direction(ds))", "0.5 * fabs(ds)"});
  return kEffect;
}

}  // namespace veridyn
