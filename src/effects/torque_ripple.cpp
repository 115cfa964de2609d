#include <cmath>

#include "effects/described_effect.hpp"
#include "math/digits.hpp"
#include "registry.hpp"

namespace veridyn {

/// A torque periodic in position: cogging, current sensors, gear teeth.
///
///   tau = cosine * cos(order s) + sine * sin(order s)
///
/// The order counts periods per turn of a revolute axis (usually the gear ratio times a small
/// integer), and is the wave number [rad/m] of a prismatic one. Find it as a sharp peak of a
/// spectrum over s.
const Effect& torque_ripple() {
  EffectTraits t;
  t.uses_position = true;
  t.depends_on_position = true;
  t.holds_at_rest = true;
  t.lasting = true;
  EffectShape order{"order", "1/turn", "rad/m", 1.0, 1.0, 1e4, true, false, 100.0};
  order.scale = ShapeScale::kWaves;
  static const DescribedEffectInC kEffect({"torque_ripple", {{"cosine", "N m", "N"}, {"sine", "N m", "N"}}, {order}, t,
      [](const AxisSample& x, const ShapeValues& shape, EffectState&, EffectColumns& row) noexcept {
        row[0] = std::cos(shape[0] * x.s);
        row[1] = std::sin(shape[0] * x.s);
      },
      nullptr,
      [](const Effect&, const std::vector<double>& values, const ShapeValues& shape, JointType type) {
        const std::string ripple = "a ripple of " + effort_text(std::hypot(values[0], values[1]), type);
        return type == JointType::kPrismatic ? ripple + ", one wave every " + text_with_unit(2.0 * M_PI / shape[0], "m")
                                             : ripple + ", " + digits(shape[0], 5) + " waves per turn";
      }},
      {"cos(#0 * s)", "sin(#0 * s)"});
  return kEffect;
}

}  // namespace veridyn
