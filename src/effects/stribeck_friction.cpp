#include <cmath>

#include "phrase.hpp"
#include "registry.hpp"
#include "sliding_direction.hpp"
#include "effects/written_in_c.hpp"

namespace veridyn {
namespace {

/// Excess of static over Coulomb friction, which decays with speed:
///
///   tau = level * sign(ds) * exp(-(|ds| / velocity)^2)
///
/// with the sign of sliding_direction(). It always opposes the motion; where the total friction
/// falls with rising speed, a position loop may stick and slip. Source: Armstrong-Helouvry,
/// Dupont and Canudas de Wit, Automatica 30(7), 1994; thesis 5.6 and its reference [50].
class StribeckFriction final : public AxisEffect, public WrittenInC {
 public:
  std::string name() const override { return "stribeck_friction"; }
  std::vector<EffectParameter> parameters() const override {
    return {{"level", "N m", "N", ParameterSign::kNonnegative}};
  }
  std::vector<EffectShape> shapes() const override {
    EffectShape velocity{"velocity", "rad/s", "m/s", 0.05, 5e-3, 1.0, true, true, 0.02};
    velocity.scale = ShapeScale::kSpeed;
    velocity.grid = {0.02, 0.06, 0.2};
    return {velocity};
  }
  EffectTraits traits(const ShapeValues& /*shape*/) const override {
    EffectTraits t;
    t.role = EffectRole::kFriction;
    t.uses_velocity = true;
    t.dry = DryFriction::kVarying;
    t.slow = true;
    return t;
  }
  void columns(const AxisSample& x, const ShapeValues& shape, EffectState& /*state*/,
               EffectColumns& row) const noexcept override {
    const double ratio = x.ds / shape[0];
    row[0] = sliding_direction(x.ds) * std::exp(-ratio * ratio);
  }
  std::vector<std::string> c_columns(const ShapeValues& shape) const override {
    const std::string v = c_number(shape[0]);
    return {"@direction(ds) * exp(-(ds / " + v + ") * (ds / " + v + "))"};
  }
  std::string phrase(const std::vector<double>& values, const ShapeValues& shape,
                     JointType type) const override {
    return parameter_text(*this, values, 0, type) +
           " of extra friction near rest, gone above about " +
           quantity(2.0 * shape[0], type == JointType::kPrismatic ? "m/s" : "rad/s");
  }
};

}  // namespace

const Effect& stribeck_friction() {
  static const StribeckFriction kEffect;
  return kEffect;
}

}  // namespace veridyn
