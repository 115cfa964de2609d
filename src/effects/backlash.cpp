#include <algorithm>
#include <cmath>

#include "contact_memory.hpp"
#include "phrase.hpp"
#include "registry.hpp"
#include "effects/written_in_c.hpp"

namespace veridyn {
namespace {

constexpr double kFree = 0.8;  // share of the half gap without contact

/// Friction behind a gap: after a reversal the motor crosses the gap freely, then meets the
/// friction again.
///
///   p <- clamp(p + step / (gap / 2), -1, 1)                     position in the gap (play operator)
///   tau = level * sign(p) * max(0, |p| - free) / (1 - free)     free = 0.8: the teeth are compliant
///
/// The model is rate independent and passive: inside the gap it is a potential of p, at its ends
/// friction. It differs from presliding_hysteresis by its dead zone. Limits: the friction behind
/// the gap must exceed the gravity torque there; a load that presses the teeth to one side hides
/// the gap. Impacts, and the lag of the link by half a gap (a second-order effect), are neglected.
/// The position in the gap starts in the middle. Source: Nordin and Gutman, Automatica 38(10),
/// 2002, for the
/// play and its contact.
class Backlash final : public AxisEffect, public WrittenInC {
 public:
  std::string name() const override { return "backlash"; }
  std::vector<EffectParameter> parameters() const override {
    return {{"level", "N m", "N", ParameterSign::kNonnegative}};
  }
  std::vector<EffectShape> shapes() const override {
    EffectShape gap{"gap", "rad", "m", 5e-3, 1e-5, 1.0, true, true, 2e-4};
    gap.scale = ShapeScale::kTravel;
    gap.grid = {1e-3, 5e-3, 2e-2};
    return {gap};
  }
  EffectTraits traits(const ShapeValues& /*shape*/) const override {
    EffectTraits t;
    t.role = EffectRole::kFriction;
    t.uses_position = true;
    t.memory = true;
    t.slow = true;
    return t;
  }
  void columns(const AxisSample& x, const ShapeValues& shape, EffectState& state,
               EffectColumns& row) const noexcept override {
    const double place =
        std::clamp(state[0] + 2.0 * step_since_last(x.s, state) / shape[0], -1.0, 1.0);
    state[0] = place;
    row[0] = std::copysign(std::max(0.0, std::abs(place) - kFree) / (1.0 - kFree), place);
  }
  std::string c_before(const ShapeValues& shape) const override {
    return "z[0] = @clamp(z[0] + 2.0 / " + c_number(shape[0]) + " * @step(s, z));";
  }
  std::vector<std::string> c_columns(const ShapeValues& /*shape*/) const override {
    return {"copysign(fmax(0.0, fabs(z[0]) - " + c_number(kFree) + ") / " + c_number(1.0 - kFree) +
            ", z[0])"};
  }
  std::string phrase(const std::vector<double>& values, const ShapeValues& shape,
                     JointType type) const override {
    return parameter_text(*this, values, 0, type) + " of friction behind a gap of " +
           shape_text(*this, shape, 0, type);
  }
};

}  // namespace

const Effect& backlash() {
  static const Backlash kEffect;
  return kEffect;
}

}  // namespace veridyn
