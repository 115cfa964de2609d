#include <cmath>

#include "phrase.hpp"
#include "registry.hpp"
#include "sliding_direction.hpp"

namespace veridyn {
namespace {

/// Friction that decays as grease warms, counted from the start of the recording:
///
///   tau = (level * sign(ds) + viscosity * ds) * exp(-time / time_constant)
///
/// with the sign of sliding_direction(). The steady-state friction is coulomb_friction and
/// viscous_friction. It requires a recording that starts cold and lasts for a good part of the time
/// constant; after a warm start the identified levels are smaller.
class WarmUp final : public AxisEffect {
 public:
  std::string name() const override { return "warm_up"; }
  std::vector<EffectParameter> parameters() const override {
    return {{"level", "N m", "N", ParameterSign::kNonnegative},
            {"viscosity", "N m s/rad", "N s/m", ParameterSign::kNonnegative}};
  }
  std::vector<EffectShape> shapes() const override {
    EffectShape time_constant{"time_constant", "s", "s", 60.0, 5.0, 2000.0, true};
    time_constant.scale = ShapeScale::kDuration;
    time_constant.grid = {0.5};
    return {time_constant};
  }
  EffectTraits traits(const ShapeValues& /*shape*/) const override {
    EffectTraits t;
    t.role = EffectRole::kFriction;
    t.uses_velocity = true;
    t.dry = DryFriction::kVarying;
    t.depends_on_time = true;
    return t;
  }
  void columns(const AxisSample& x, const ShapeValues& shape, EffectState& /*state*/,
               EffectColumns& row) const noexcept override {
    const double cold = std::exp(-x.time / shape[0]);
    row[0] = sliding_direction(x.ds) * cold;
    row[1] = x.ds * cold;
  }
  std::string phrase(const std::vector<double>& values, const ShapeValues& shape,
                     JointType type) const override {
    return parameter_text(*this, values, 0, type) + " of Coulomb and " +
           parameter_text(*this, values, 1, type) +
           " of viscous friction that fade with a time constant of " +
           shape_text(*this, shape, 0, type);
  }
};

}  // namespace

const Effect& warm_up() {
  static const WarmUp kEffect;
  return kEffect;
}

}  // namespace veridyn
