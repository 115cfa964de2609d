#include <cmath>

#include "phrase.hpp"
#include "registry.hpp"
#include "effects/written_in_c.hpp"

namespace veridyn {
namespace {

/// tau = coefficient * ds * |ds|: drag of a fluid, or of fans and churned grease, at high speed.
class QuadraticDrag final : public AxisEffect, public WrittenInC {
 public:
  std::string name() const override { return "quadratic_drag"; }
  std::vector<EffectParameter> parameters() const override {
    return {{"coefficient", "N m s^2/rad^2", "N s^2/m^2", ParameterSign::kNonnegative}};
  }
  EffectTraits traits(const ShapeValues& /*shape*/) const override {
    EffectTraits t;
    t.role = EffectRole::kFriction;
    t.uses_velocity = true;
    return t;
  }
  void columns(const AxisSample& x, const ShapeValues& /*shape*/, EffectState& /*state*/,
               EffectColumns& row) const noexcept override {
    row[0] = x.ds * std::abs(x.ds);
  }
  std::vector<std::string> c_columns(const ShapeValues& /*shape*/) const override {
    return {"ds * fabs(ds)"};
  }
  std::string phrase(const std::vector<double>& values, const ShapeValues& /*shape*/,
                     JointType type) const override {
    return parameter_text(*this, values, 0, type) + " of drag that grows with the square of speed";
  }
};

}  // namespace

const Effect& quadratic_drag() {
  static const QuadraticDrag kEffect;
  return kEffect;
}

}  // namespace veridyn
