#include "contact_memory.hpp"
#include "effects/described_effect.hpp"
#include "registry.hpp"

namespace veridyn {

/// tau = level * z: friction with a memory z in [-1, 1] of the path since the last reversal, see
/// advance_contact().
///
/// After a reversal out of full sliding, z = 1 - 2 (1 - exp(-path / distance)) in the previous direction. Far
/// beyond `distance` it is Coulomb friction; at rest it keeps its value. Several memories on one axis, each
/// with its distance, are several terms. Noise of s reduces |z|: smooth the position first.
///
/// It is passive: from z it returns at most level * distance * (|z| - ln(1 + |z|)), less than was stored.
/// Source: Dahl 1968, as in thesis 5.6 (z there), without the speed-dependent terms of its generalisations.
const Effect& presliding_hysteresis() {
  EffectTraits t;
  t.role = EffectRole::kFriction;
  t.uses_position = true;
  t.memory = true;
  t.slow = true;
  t.mixed_axes = true;
  EffectShape distance{"distance", "rad", "m", 5e-3, 1e-5, 1.0, true, true, 1.5e-4};
  distance.scale = ShapeScale::kTravel;
  distance.grid = {3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.25};
  static const DescribedEffectInC kEffect({"presliding_hysteresis", {{"level", "N m", "N", ParameterSign::kNonnegative}}, {distance}, t,
      [](const AxisSample& x, const ShapeValues& shape, EffectState& state, EffectColumns& row) noexcept {
        row[0] = advance_contact(x.s, shape[0], state);
      },
      "% of friction with memory: after a reversal it builds up over #"},
      {"@contact(s, #0, z)"});
  return kEffect;
}

}  // namespace veridyn
