#include <cmath>

#include "math/digits.hpp"
#include "phrase.hpp"
#include "registry.hpp"
#include "effects/written_in_c.hpp"

namespace veridyn {
namespace {

/// A torque periodic in position: cogging, current sensors, gear teeth.
///
///   tau = cosine * cos(order s) + sine * sin(order s)
///
/// The order counts periods per turn of a revolute axis (usually the gear ratio times a small
/// integer), and is the wave number [rad/m] of a prismatic one. Find it as a sharp peak of a
/// spectrum over s.
class TorqueRipple final : public AxisEffect, public WrittenInC {
 public:
  std::string name() const override { return "torque_ripple"; }
  std::vector<EffectParameter> parameters() const override {
    return {{"cosine", "N m", "N", ParameterSign::kAny}, {"sine", "N m", "N", ParameterSign::kAny}};
  }
  std::vector<EffectShape> shapes() const override {
    EffectShape order{"order", "1/turn", "rad/m", 1.0, 1.0, 1e4, true, false, 100.0};
    order.scale = ShapeScale::kWaves;
    return {order};
  }
  EffectTraits traits(const ShapeValues& /*shape*/) const override {
    EffectTraits t;
    t.uses_position = true;
    t.depends_on_position = true;
    t.holds_at_rest = true;
    t.lasting = true;
    return t;
  }
  void columns(const AxisSample& x, const ShapeValues& shape, EffectState& /*state*/,
               EffectColumns& row) const noexcept override {
    row[0] = std::cos(shape[0] * x.s);
    row[1] = std::sin(shape[0] * x.s);
  }
  std::vector<std::string> c_columns(const ShapeValues& shape) const override {
    const std::string angle = c_number(shape[0]) + " * s";
    return {"cos(" + angle + ")", "sin(" + angle + ")"};
  }
  std::string phrase(const std::vector<double>& values, const ShapeValues& shape,
                     JointType type) const override {
    const std::string ripple = "a ripple of " + effort_text(std::hypot(values[0], values[1]), type);
    if (type == JointType::kPrismatic)
      return ripple + ", one wave every " + quantity(2.0 * M_PI / shape[0], "m");
    return ripple + ", " + digits(shape[0], 5) + " waves per turn";
  }
};

}  // namespace

const Effect& torque_ripple() {
  static const TorqueRipple kEffect;
  return kEffect;
}

}  // namespace veridyn
