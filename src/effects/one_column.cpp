#include <cmath>

#include "effects/described_effect.hpp"
#include "registry.hpp"

namespace veridyn {

/// tau = inertia * dds: the motor's rotor and gears, reflected to the axis.
const Effect& rotor_inertia() {
  EffectTraits t;
  t.role = EffectRole::kInertia;
  t.uses_acceleration = true;
  t.affine = true;
  t.lasting = true;
  t.urdf_attribute = "armature";
  static const DescribedEffectInC kEffect({"rotor_inertia", {{"inertia", "kg m^2", "kg", ParameterSign::kNonnegative}}, {}, t,
      [](const AxisSample& x, const ShapeValues&, EffectState&, EffectColumns& row) noexcept { row[0] = x.dds; },
      "% of reflected rotor inertia"}, {"dds"});
  return kEffect;
}

/// tau = coefficient * ds.
const Effect& viscous_friction() {
  EffectTraits t;
  t.role = EffectRole::kFriction;
  t.uses_velocity = true;
  t.affine = true;
  t.elementary = true;
  t.mixed_axes = true;
  t.urdf_attribute = "damping";
  static const DescribedEffectInC kEffect({"viscous_friction", {{"coefficient", "N m s/rad", "N s/m", ParameterSign::kNonnegative}}, {}, t,
      [](const AxisSample& x, const ShapeValues&, EffectState&, EffectColumns& row) noexcept { row[0] = x.ds; },
      "% of viscous friction"}, {"ds"});
  return kEffect;
}

/// tau = coefficient * ds * |ds|: drag of a fluid, or of fans and churned grease, at high speed.
const Effect& quadratic_drag() {
  EffectTraits t;
  t.role = EffectRole::kFriction;
  t.uses_velocity = true;
  static const DescribedEffectInC kEffect({"quadratic_drag", {{"coefficient", "N m s^2/rad^2", "N s^2/m^2", ParameterSign::kNonnegative}}, {}, t,
      [](const AxisSample& x, const ShapeValues&, EffectState&, EffectColumns& row) noexcept { row[0] = x.ds * std::abs(x.ds); },
      "% of drag that grows with the square of speed"}, {"ds * fabs(ds)"});
  return kEffect;
}

/// tau = offset: a wrong zero of the torque measurement, or different friction in the two directions; one
/// recording of motion cannot separate the two (seed errata on thesis 4.13).
const Effect& torque_offset() {
  EffectTraits t;
  t.affine = true;
  t.holds_at_rest = true;
  t.elementary = true;
  t.urdf_attribute = "offset";
  static const DescribedEffectInC kEffect({"torque_offset", {{"offset", "N m", "N", ParameterSign::kAny}}, {}, t,
      [](const AxisSample&, const ShapeValues&, EffectState&, EffectColumns& row) noexcept { row[0] = 1.0; },
      "a constant $ of %"}, {"1.0"});
  return kEffect;
}

}  // namespace veridyn
