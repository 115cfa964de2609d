#include "effects/described_effect.hpp"
#include "registry.hpp"

namespace veridyn {

/// tau = rate * time: a torque that grows during the recording, as from warming current sensors.
/// Time counts from the start of the recording; its initial value is torque_offset.
const Effect& torque_drift() {
  EffectTraits t;
  t.depends_on_time = true;
  static const DescribedEffect kEffect({"torque_drift", {{"rate", "N m/s", "N/s"}}, {}, t,
      [](const AxisSample& x, const ShapeValues&, EffectState&, EffectColumns& row) noexcept { row[0] = x.time; },
      nullptr,
      [](const Effect&, const std::vector<double>& values, const ShapeValues&, JointType type) {
        return "a " + effort_word(type) + " that drifts by " + effort_text(60.0 * values[0], type) + " per minute";
      }});
  return kEffect;
}

}  // namespace veridyn
