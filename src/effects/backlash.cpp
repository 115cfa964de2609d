#include <algorithm>
#include <cmath>

#include "contact_memory.hpp"
#include "effects/described_effect.hpp"
#include "registry.hpp"

namespace veridyn {
namespace {

constexpr double kFree = 0.8;  // share of the half gap without contact

}  // namespace

/// Friction behind a gap: after a reversal the motor crosses the gap without this friction and then meets it
/// again.
///
///   p <- clamp(p + step / (gap / 2), -1, 1)                     position in the gap (play operator)
///   tau = level * sign(p) * max(0, |p| - free) / (1 - free)     free = 0.8, since the teeth are compliant
///
/// The model is rate independent and passive: inside the gap it is a potential of p, at its ends
/// friction. It differs from presliding_hysteresis by its dead zone. Limits: the friction behind
/// the gap must exceed the gravity torque there; a load that presses the teeth to one side hides
/// the gap. Impacts, and the lag of the link by half a gap (a second-order effect), are neglected. At first p
/// is zero, the middle of the gap. Source: Nordin and Gutman, Automatica 38(10), 2002, for the play and its
/// contact.
const Effect& backlash() {
  EffectTraits t;
  t.role = EffectRole::kFriction;
  t.uses_position = true;
  t.memory = true;
  t.slow = true;
  EffectShape gap{"gap", "rad", "m", 5e-3, 1e-5, 1.0, true, true, 2e-4};
  gap.scale = ShapeScale::kTravel;
  gap.grid = {1e-3, 5e-3, 2e-2};
  static const DescribedEffectInC kEffect({"backlash", {{"level", "N m", "N", ParameterSign::kNonnegative}}, {gap}, t,
      [](const AxisSample& x, const ShapeValues& shape, EffectState& state, EffectColumns& row) noexcept {
        state[0] = std::clamp(state[0] + 2.0 * step_since_last(x.s, state) / shape[0], -1.0, 1.0);
        row[0] = std::copysign(std::max(0.0, std::abs(state[0]) - kFree) / (1.0 - kFree), state[0]);
      },
      "% of friction behind a gap of #"},
      {"copysign(fmax(0.0, fabs(z[0]) - " + c_number(kFree) + ") / " + c_number(1.0 - kFree) + ", z[0])"},
      "z[0] = @clamp(z[0] + 2.0 / #0 * @step(s, z));");
  return kEffect;
}

}  // namespace veridyn
