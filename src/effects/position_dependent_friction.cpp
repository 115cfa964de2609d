#include "contact_memory.hpp"
#include "phrase.hpp"
#include "registry.hpp"
#include "effects/written_in_c.hpp"

namespace veridyn {
namespace {

/// Friction whose level depends on the position:
///
///   tau = sign(ds) * (slope * (s - centre) + curvature * (s - centre)^2)
///
/// The level at the centre is coulomb_friction. The sign is sliding_direction(), or with `distance`
/// in the file the contact memory of presliding_hysteresis, which is valid at rest too; use the
/// distance found there. On an arm whose gravity torque varies with s it is confounded with
/// load_dependent_friction. Source: thesis 5.6, "a change in friction based on the joint position".
class PositionDependentFriction final : public AxisEffect, public WrittenInC {
 public:
  std::string name() const override { return "position_dependent_friction"; }
  std::vector<EffectParameter> parameters() const override {
    return {{"slope", "N m/rad", "N/m", ParameterSign::kAny},
            {"curvature", "N m/rad^2", "N/m^2", ParameterSign::kAny}};
  }
  std::vector<EffectShape> shapes() const override {
    EffectShape centre{"centre", "rad", "m", 0.0, -10.0, 10.0, false, false};
    centre.scale = ShapeScale::kMiddle;
    return {centre, {"distance", "rad", "m", 0.0, 1e-5, 1.0, true, false}};
  }
  EffectTraits traits(const ShapeValues& shape) const override {
    EffectTraits t;
    t.role = EffectRole::kFriction;
    t.uses_position = true;
    t.uses_velocity = shape[1] == 0.0;
    t.memory = shape[1] > 0.0;
    t.dry = t.memory ? DryFriction::kNone : DryFriction::kVarying;
    t.depends_on_position = true;
    return t;
  }
  void columns(const AxisSample& x, const ShapeValues& shape, EffectState& state,
               EffectColumns& row) const noexcept override {
    const double direction = friction_direction(x, shape[1], state);
    const double way = x.s - shape[0];
    row[0] = direction * way;
    row[1] = direction * way * way;
  }
  std::string c_before(const ShapeValues& shape) const override {
    return shape[1] > 0.0 ? c_friction_direction(shape[1]) + ";" : "";
  }
  std::vector<std::string> c_columns(const ShapeValues& shape) const override {
    const std::string way = "(s - " + c_number(shape[0]) + ")";
    const std::string direction = shape[1] > 0.0 ? "z[0]" : c_friction_direction(0.0);
    return {direction + " * " + way, direction + " * " + way + " * " + way};
  }
  std::string phrase(const std::vector<double>& values, const ShapeValues& shape,
                     JointType type) const override {
    return "friction that changes with position, by " + parameter_text(*this, values, 0, type) +
           " and " + parameter_text(*this, values, 1, type) + " from " +
           shape_text(*this, shape, 0, type);
  }
};

}  // namespace

const Effect& position_dependent_friction() {
  static const PositionDependentFriction kEffect;
  return kEffect;
}

}  // namespace veridyn
