#include <cmath>

#include "phrase.hpp"
#include "registry.hpp"
#include "sliding_direction.hpp"
#include "effects/written_in_c.hpp"

namespace veridyn {
namespace {

/// tau = level * sign(ds), or level * tanh(slope ds / 2) where the file gives a slope: the sigmoid
/// 2 / (1 + exp(-slope ds)) - 1 of thesis (4.14) with the errata's sign.
///
/// Without a slope the sign is sliding_direction(), which is linear near zero speed.
class CoulombFriction final : public AxisEffect, public WrittenInC {
 public:
  std::string name() const override { return "coulomb_friction"; }
  std::vector<EffectParameter> parameters() const override {
    return {{"level", "N m", "N", ParameterSign::kNonnegative}};
  }
  std::vector<EffectShape> shapes() const override {
    EffectShape slope{"slope", "s/rad", "s/m", 0.0, 10.0, 1e4, true, false};
    // Slopes times the largest speed, for arms whose sign function is smooth.
    slope.grid = {50.0, 100.0, 200.0};
    return {slope};
  }
  EffectTraits traits(const ShapeValues& shape) const override {
    EffectTraits t;
    t.role = EffectRole::kFriction;
    t.uses_velocity = true;
    t.dry = shape[0] > 0.0 ? DryFriction::kNone : DryFriction::kConstant;
    t.elementary = true;
    t.mixed_axes = true;
    t.urdf_attribute = "friction";
    return t;
  }
  void columns(const AxisSample& x, const ShapeValues& shape, EffectState& /*state*/,
               EffectColumns& row) const noexcept override {
    const double slope = shape[0];
    row[0] = slope > 0.0 ? std::tanh(0.5 * slope * x.ds) : sliding_direction(x.ds);
  }
  std::vector<std::string> c_columns(const ShapeValues& shape) const override {
    return {shape[0] > 0.0 ? "tanh(0.5 * " + c_number(shape[0]) + " * ds)" : "@direction(ds)"};
  }
  std::string phrase(const std::vector<double>& values, const ShapeValues& shape,
                     JointType type) const override {
    std::string out = parameter_text(*this, values, 0, type) + " of Coulomb friction";
    if (shape[0] > 0.0)
      out += " with a smooth step, over " +
             text_with_unit(2.0 / shape[0], type == JointType::kPrismatic ? "m/s" : "rad/s");
    return out;
  }
};

}  // namespace

const Effect& coulomb_friction() {
  static const CoulombFriction kEffect;
  return kEffect;
}

}  // namespace veridyn
