#include <algorithm>
#include <cmath>

#include "phrase.hpp"
#include "registry.hpp"
#include "sliding_direction.hpp"
#include "effects/written_in_c.hpp"

namespace veridyn {
namespace {

/// Friction of lubricated gears, which grows less than linearly with speed:
///
///   tau = coefficient * sign(ds) * |ds|^exponent,   0 < exponent < 1
///
/// Below kRestSpeed it is linear, because the power has an infinite derivative at zero. The
/// coefficient is the friction at 1 rad/s or 1 m/s.
class SublinearViscous final : public AxisEffect, public WrittenInC {
 public:
  std::string name() const override { return "sublinear_viscous"; }
  std::vector<EffectParameter> parameters() const override {
    return {
        {"coefficient", "N m (s/rad)^exponent", "N (s/m)^exponent", ParameterSign::kNonnegative}};
  }
  std::vector<EffectShape> shapes() const override {
    EffectShape exponent{"exponent", "1", "1", 0.5, 0.3, 0.9, false};
    exponent.scale = ShapeScale::kAbsolute;
    exponent.grid = {0.4, 0.7};
    return {exponent};
  }
  EffectTraits traits(const ShapeValues& /*shape*/) const override {
    EffectTraits t;
    t.role = EffectRole::kFriction;
    t.uses_velocity = true;
    t.dry = DryFriction::kVarying;
    return t;
  }
  void columns(const AxisSample& x, const ShapeValues& shape, EffectState& /*state*/,
               EffectColumns& row) const noexcept override {
    row[0] = sliding_direction(x.ds) * std::pow(std::max(std::abs(x.ds), kRestSpeed), shape[0]);
  }
  std::vector<std::string> c_columns(const ShapeValues& shape) const override {
    return {"@direction(ds) * pow(fmax(fabs(ds), " + c_number(kRestSpeed) + "), " + c_number(shape[0]) + ")"};
  }
  std::string phrase(const std::vector<double>& values, const ShapeValues& shape,
                     JointType type) const override {
    return effort_text(values[0], type) + " of friction at " +
           (type == JointType::kPrismatic ? "1 m/s" : "1 rad/s") +
           " that grows with speed to the power " + shape_text(*this, shape, 0, type);
  }
};

}  // namespace

const Effect& sublinear_viscous() {
  static const SublinearViscous kEffect;
  return kEffect;
}

}  // namespace veridyn
