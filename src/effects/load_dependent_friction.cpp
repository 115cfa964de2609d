#include <cmath>

#include "contact_memory.hpp"
#include "phrase.hpp"
#include "registry.hpp"
#include "effects/written_in_c.hpp"

namespace veridyn {
namespace {

/// Friction that rises with the load of gears or guides:
///
///   tau = coefficient * |load| * sign(ds)
///
/// where the load is the torque of the rigid bodies along the axis, known only if the bodies have values. The
/// sign is sliding_direction(), or with `distance` in the file the contact memory of presliding_hysteresis.
/// Friction without load is coulomb_friction. Source: Hamon, Gautier, Garrec and Janot, IROS 2010.
class LoadDependentFriction final : public AxisEffect, public WrittenInC {
 public:
  std::string name() const override { return "load_dependent_friction"; }
  std::vector<EffectParameter> parameters() const override {
    return {{"coefficient", "1", "1", ParameterSign::kNonnegative}};
  }
  std::vector<EffectShape> shapes() const override {
    return {{"distance", "rad", "m", 0.0, 1e-5, 1.0, true, false}};
  }
  EffectTraits traits(const ShapeValues& shape) const override {
    EffectTraits t;
    t.role = EffectRole::kFriction;
    t.uses_position = shape[0] > 0.0;
    t.uses_velocity = !t.uses_position;
    t.uses_load = true;
    t.memory = t.uses_position;
    t.dry = t.memory ? DryFriction::kNone : DryFriction::kVarying;
    return t;
  }
  void columns(const AxisSample& x, const ShapeValues& shape, EffectState& state,
               EffectColumns& row) const noexcept override {
    row[0] = std::abs(x.load) * friction_direction(x, shape[0], state);
  }
  std::vector<std::string> c_columns(const ShapeValues& shape) const override {
    return {"fabs(load) * " + c_friction_direction(shape[0])};
  }
  std::string phrase(const std::vector<double>& values, const ShapeValues& /*shape*/,
                     JointType type) const override {
    return "friction of " + text_with_unit(100.0 * values[0], "%") + " of the " + effort_word(type) +
           " that it carries";
  }
};

}  // namespace

const Effect& load_dependent_friction() {
  static const LoadDependentFriction kEffect;
  return kEffect;
}

}  // namespace veridyn
