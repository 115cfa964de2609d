#include "effects/described_effect.hpp"
#include "registry.hpp"
#include "sliding_direction.hpp"

namespace veridyn {

/// Force on this axis from another coordinate, through a cable, hose or tendon:
///
///   tau = stiffness * from_s + curvature * from_s^2 + drag * sign(from_ds)
///
/// The tension depends on the other coordinate's position, and the friction on the other
/// coordinate's motion (sign of sliding_direction(); the sigmoid of thesis (4.14) differs only
/// below the rest speed). The routing determines all signs. The force has no potential: the
/// reaction on the other coordinate is a term of its own.
const Effect& cable_coupling() {
  EffectTraits t;
  t.uses_source = true;
  t.depends_on_position = true;
  t.holds_at_rest = true;
  t.lasting = true;
  const std::string per = std::string("/") + kSourceUnit;
  static const DescribedEffectInC kEffect({"cable_coupling", {{"stiffness", "N m" + per, "N" + per}, {"curvature", "N m" + per + "^2", "N" + per + "^2"}, {"drag", "N m", "N"}}, {}, t,
      [](const AxisSample& x, const ShapeValues&, EffectState&, EffectColumns& row) noexcept {
        row[0] = x.from_s;
        row[1] = x.from_s * x.from_s;
        row[2] = sliding_direction(x.from_ds);
      },
      "a cable from another joint: % and % with its position, % of drag with its motion"},
      {"from_s", "from_s * from_s", "@direction(from_ds)"});
  return kEffect;
}

}  // namespace veridyn
