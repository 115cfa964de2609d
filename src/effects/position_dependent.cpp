#include "contact_memory.hpp"
#include "effects/described_effect.hpp"
#include "registry.hpp"

namespace veridyn {
namespace {

// Friction that depends on the position, by its distance from a centre:
//
//   tau = motion * (slope * (s - centre) + curvature * (s - centre)^2)
EffectTraits traits_of_friction() {
  EffectTraits t;
  t.role = EffectRole::kFriction;
  t.uses_position = true;
  t.uses_velocity = true;
  t.depends_on_position = true;
  return t;
}

EffectShape centre_shape() {
  EffectShape out{"centre", "rad", "m", 0.0, -10.0, 10.0, false, false};
  out.scale = ShapeScale::kMiddle;
  return out;
}

void set_columns(double motion, double from_centre, EffectColumns& row) {
  row[0] = motion * from_centre;
  row[1] = motion * from_centre * from_centre;
}

class PositionDependentFriction final : public DescribedEffectInC {
 public:
  using DescribedEffectInC::DescribedEffectInC;
  EffectTraits traits(const ShapeValues& shape) const override {
    EffectTraits t = DescribedEffectInC::traits(shape);
    t.uses_velocity = shape[1] == 0.0;
    t.memory = shape[1] > 0.0;
    t.dry = t.memory ? DryFriction::kNone : DryFriction::kVarying;
    return t;
  }
  std::vector<std::string> c_columns(const ShapeValues& shape) const override {
    const std::string from_centre = " * (s - " + c_number(shape[0]) + ")", motion = shape[1] > 0.0 ? "z[0]" : c_friction_direction(0.0);
    return {motion + from_centre, motion + from_centre + from_centre};
  }
  std::string c_before(const ShapeValues& shape) const override {
    return shape[1] > 0.0 ? c_friction_direction(shape[1]) + ";" : "";
  }
};

}  // namespace

/// The friction for motion = sign(ds); the level at the centre is coulomb_friction. The sign is
/// sliding_direction(), or with `distance` in the file the contact memory of presliding_hysteresis, which is
/// valid at rest too; use the distance found for that effect. On an arm whose gravity torque varies with s it
/// is confounded with load_dependent_friction. Source: thesis 5.6, "a change in friction based on the joint
/// position".
const Effect& position_dependent_friction() {
  static const PositionDependentFriction kEffect({"position_dependent_friction", {{"slope", "N m/rad", "N/m"}, {"curvature", "N m/rad^2", "N/m^2"}},
      {centre_shape(), {"distance", "rad", "m", 0.0, 1e-5, 1.0, true, false}}, traits_of_friction(),
      [](const AxisSample& x, const ShapeValues& shape, EffectState& state, EffectColumns& row) noexcept {
        set_columns(friction_direction(x, shape[1], state), x.s - shape[0], row);
      },
      "friction that changes with position, by % and % from #"}, {});
  return kEffect;
}

/// The friction for motion = ds, caused by bending hoses and harnesses; the coefficient at the centre is
/// viscous_friction. The inertia's cross terms in dq_i dq_j have other columns and are not confounded with it
/// while one joint moves alone.
const Effect& position_dependent_viscosity() {
  static const DescribedEffectInC kEffect({"position_dependent_viscosity", {{"slope", "N m s/rad^2", "N s/m^2"}, {"curvature", "N m s/rad^3", "N s/m^3"}},
      {centre_shape()}, traits_of_friction(),
      [](const AxisSample& x, const ShapeValues& shape, EffectState&, EffectColumns& row) noexcept { set_columns(x.ds, x.s - shape[0], row); },
      "viscous friction that changes with position, by % and % from #"},
      {"ds * (s - #0)", "ds * (s - #0) * (s - #0)"});
  return kEffect;
}

}  // namespace veridyn
