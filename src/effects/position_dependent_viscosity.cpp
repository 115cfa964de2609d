#include "phrase.hpp"
#include "registry.hpp"
#include "effects/written_in_c.hpp"

namespace veridyn {
namespace {

/// Viscous friction whose coefficient depends on the position:
///
///   tau = ds * (slope * (s - centre) + curvature * (s - centre)^2)
///
/// The coefficient at the centre is viscous_friction. Bending hoses and harnesses cause it; the
/// inertia's cross terms in dq_i dq_j have other columns and are not confounded with it while one
/// joint moves alone.
class PositionDependentViscosity final : public AxisEffect, public WrittenInC {
 public:
  std::string name() const override { return "position_dependent_viscosity"; }
  std::vector<EffectParameter> parameters() const override {
    return {{"slope", "N m s/rad^2", "N s/m^2", ParameterSign::kAny},
            {"curvature", "N m s/rad^3", "N s/m^3", ParameterSign::kAny}};
  }
  std::vector<EffectShape> shapes() const override {
    EffectShape centre{"centre", "rad", "m", 0.0, -10.0, 10.0, false, false};
    centre.scale = ShapeScale::kMiddle;
    return {centre};
  }
  EffectTraits traits(const ShapeValues& /*shape*/) const override {
    EffectTraits t;
    t.role = EffectRole::kFriction;
    t.uses_position = true;
    t.uses_velocity = true;
    t.depends_on_position = true;
    return t;
  }
  void columns(const AxisSample& x, const ShapeValues& shape, EffectState& /*state*/,
               EffectColumns& row) const noexcept override {
    const double way = x.s - shape[0];
    row[0] = x.ds * way;
    row[1] = x.ds * way * way;
  }
  std::vector<std::string> c_columns(const ShapeValues& shape) const override {
    const std::string way = "(s - " + c_number(shape[0]) + ")";
    return {"ds * " + way, "ds * " + way + " * " + way};
  }
  std::string phrase(const std::vector<double>& values, const ShapeValues& shape,
                     JointType type) const override {
    return "viscous friction that changes with position, by " +
           parameter_text(*this, values, 0, type) + " and " +
           parameter_text(*this, values, 1, type) + " from " + shape_text(*this, shape, 0, type);
  }
};

}  // namespace

const Effect& position_dependent_viscosity() {
  static const PositionDependentViscosity kEffect;
  return kEffect;
}

}  // namespace veridyn
