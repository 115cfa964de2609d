#include "phrase.hpp"
#include "registry.hpp"
#include "sliding_direction.hpp"
#include "effects/written_in_c.hpp"

namespace veridyn {
namespace {

/// Force on this axis from another coordinate, through a cable, hose or tendon:
///
///   tau = stiffness * from_s + curvature * from_s^2 + drag * sign(from_ds)
///
/// The tension depends on the other coordinate's position, and the friction on the other
/// coordinate's motion (sign of sliding_direction(); the sigmoid of thesis (4.14) differs only
/// below the rest speed). The routing determines all signs. The force has no potential: the
/// reaction on the other coordinate is a term of its own.
class CableCoupling final : public AxisEffect, public WrittenInC {
 public:
  std::string name() const override { return "cable_coupling"; }
  std::vector<EffectParameter> parameters() const override {
    const std::string per = std::string("/") + kSourceUnit;
    return {{"stiffness", "N m" + per, "N" + per, ParameterSign::kAny},
            {"curvature", "N m" + per + "^2", "N" + per + "^2", ParameterSign::kAny},
            {"drag", "N m", "N", ParameterSign::kAny}};
  }
  EffectTraits traits(const ShapeValues& /*shape*/) const override {
    EffectTraits t;
    t.uses_source = true;
    t.depends_on_position = true;
    t.holds_at_rest = true;
    t.lasting = true;
    return t;
  }
  void columns(const AxisSample& x, const ShapeValues& /*shape*/, EffectState& /*state*/,
               EffectColumns& row) const noexcept override {
    row[0] = x.from_s;
    row[1] = x.from_s * x.from_s;
    row[2] = sliding_direction(x.from_ds);
  }
  std::vector<std::string> c_columns(const ShapeValues& /*shape*/) const override {
    return {"from_s", "from_s * from_s", "@direction(from_ds)"};
  }
  std::string phrase(const std::vector<double>& values, const ShapeValues& /*shape*/,
                     JointType type) const override {
    return "a cable from another joint: " + parameter_text(*this, values, 0, type) + " and " +
           parameter_text(*this, values, 1, type) + " with its position, " +
           parameter_text(*this, values, 2, type) + " of drag with its motion";
  }
};

}  // namespace

const Effect& cable_coupling() {
  static const CableCoupling kEffect;
  return kEffect;
}

}  // namespace veridyn
