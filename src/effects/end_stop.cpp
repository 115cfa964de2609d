#include <algorithm>

#include "effects/described_effect.hpp"
#include "math/digits.hpp"
#include "registry.hpp"

namespace veridyn {

/// A stop or a bumper at one end of the travel: a spring that acts beyond a position only,
///
///   tau = side * stiffness * max(0, side * (s - centre) - reach)
///
/// with side = 1 at the upper end and -1 at the lower one; it begins at s = centre + side * reach.
const Effect& end_stop() {
  EffectTraits t;
  t.uses_position = true;
  t.depends_on_position = true;
  t.holds_at_rest = true;
  t.lasting = true;
  EffectShape centre{"centre", "rad", "m", 0.0, -10.0, 10.0, false, false};
  centre.scale = ShapeScale::kMiddle;
  EffectShape reach{"reach", "rad", "m", 0.1, 1e-3, 20.0, true, true, 0.01};
  reach.scale = ShapeScale::kTravel;
  reach.grid = {0.15, 0.25, 0.35};
  EffectShape side{"side", "1", "1", 1.0, -1.0, 1.0, false, false};
  side.scale = ShapeScale::kAbsolute;
  side.grid = {1.0, -1.0};
  static const DescribedEffectInC kEffect({"end_stop", {{"stiffness", "N m/rad", "N/m", ParameterSign::kNonnegative}}, {centre, reach, side}, t,
      [](const AxisSample& x, const ShapeValues& shape, EffectState&, EffectColumns& row) noexcept { row[0] = shape[2] * std::max(0.0, shape[2] * (x.s - shape[0]) - shape[1]); },
      nullptr,
      [](const Effect& e, const std::vector<double>& values, const ShapeValues& shape, JointType type) {
        return "a stop or bumper of " + parameter_text(e, values, 0, type) + " at its " + (shape[2] > 0.0 ? "upper" : "lower") + " end, from " +
               digits(shape[0] + shape[2] * shape[1], 3) + (type == JointType::kPrismatic ? " m" : " rad") + " on";
      }, true},
      {"#2 * fmax(0.0, #2 * (s - #0) - #1)"});
  return kEffect;
}

}  // namespace veridyn
