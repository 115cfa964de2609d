#include <algorithm>
#include <cmath>

#include "effects/described_effect.hpp"
#include "registry.hpp"
#include "sliding_direction.hpp"

namespace veridyn {

/// Friction of lubricated gears, which grows less than linearly with speed:
///
///   tau = coefficient * sign(ds) * |ds|^exponent,   0 < exponent < 1
///
/// Below kRestSpeed it is linear, because the power has an infinite derivative at zero. The
/// coefficient is the friction at 1 rad/s or 1 m/s.
const Effect& sublinear_viscous() {
  EffectTraits t;
  t.role = EffectRole::kFriction;
  t.uses_velocity = true;
  t.dry = DryFriction::kVarying;
  EffectShape exponent{"exponent", "1", "1", 0.5, 0.3, 0.9, false};
  exponent.scale = ShapeScale::kAbsolute;
  exponent.grid = {0.4, 0.7};
  static const DescribedEffectInC kEffect({"sublinear_viscous", {{"coefficient", "N m (s/rad)^exponent", "N (s/m)^exponent", ParameterSign::kNonnegative}}, {exponent}, t,
      [](const AxisSample& x, const ShapeValues& shape, EffectState&, EffectColumns& row) noexcept { row[0] = sliding_direction(x.ds) * std::pow(std::max(std::abs(x.ds), kRestSpeed), shape[0]); },
      nullptr,
      [](const Effect& e, const std::vector<double>& values, const ShapeValues& shape, JointType type) {
        return effort_text(values[0], type) + " of friction at " + (type == JointType::kPrismatic ? "1 m/s" : "1 rad/s") +
               " that grows with speed to the power " + shape_text(e, shape, 0, type);
      }},
      {"@direction(ds) * pow(fmax(fabs(ds), " + c_number(kRestSpeed) + "), #0)"});
  return kEffect;
}

}  // namespace veridyn
