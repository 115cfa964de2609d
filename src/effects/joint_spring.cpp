#include <cmath>

#include "phrase.hpp"
#include "registry.hpp"
#include "effects/written_in_c.hpp"

namespace veridyn {
namespace {

/// tau = stiffness * s, unloaded at s = 0 (the axis' offset shifts it).
///
/// With a lever: a straight spring between a fixed anchor, `anchor` metres from the axis, and a pin
/// on the moving part, `lever` metres from it; its length is l^2 = lever^2 + anchor^2 - 2 lever
/// anchor cos(s + angle):
///
///   tau = stiffness * (l - rest_length) * dl/ds
///
/// The stiffness is then that of the spring, in N/m. The torque is discontinuous where the pin
/// meets the anchor (l = 0).
class JointSpring final : public AxisEffect, public WrittenInC {
 public:
  std::string name() const override { return "joint_spring"; }
  std::vector<EffectParameter> parameters() const override {
    return {{"stiffness", "N m/rad", "N/m", ParameterSign::kNonnegative}};
  }
  std::vector<EffectShape> shapes() const override {
    return {{"lever", "m", "m", 0.0, 1e-3, 1.0, true, false},
            {"anchor", "m", "m", 0.0, 1e-3, 1.0, true, false},
            {"rest_length", "m", "m", 0.0, 0.0, 1.0, false, false},
            {"angle", "rad", "rad", 0.0, -3.2, 3.2, false, false}};
  }
  EffectTraits traits(const ShapeValues& shape) const override {
    EffectTraits t;
    t.uses_position = true;
    t.affine = shape[0] == 0.0;
    t.depends_on_position = true;
    t.holds_at_rest = true;
    t.lasting = true;
    t.urdf_attribute = "stiffness";
    return t;
  }
  void columns(const AxisSample& x, const ShapeValues& shape, EffectState& /*state*/,
               EffectColumns& row) const noexcept override {
    const double lever = shape[0];
    const double anchor = shape[1];
    if (lever == 0.0) {
      row[0] = x.s;
      return;
    }
    const double angle = x.s + shape[3];
    const double length =
        std::sqrt(lever * lever + anchor * anchor - 2.0 * lever * anchor * std::cos(angle));
    row[0] = length > 0.0 ? (length - shape[2]) * lever * anchor * std::sin(angle) / length : 0.0;
  }
  std::vector<std::string> c_columns(const ShapeValues& shape) const override {
    if (shape[0] == 0.0) return {"s"};
    const std::string angle = "(s + " + c_number(shape[3]) + ")";
    const std::string length = "sqrt(" + c_number(shape[0] * shape[0] + shape[1] * shape[1]) + " - " +
                               c_number(2.0 * shape[0] * shape[1]) + " * cos(" + angle + "))";
    return {length + " > 0.0 ? (" + length + " - " + c_number(shape[2]) + ") * " +
            c_number(shape[0] * shape[1]) + " * sin(" + angle + ") / " + length + " : 0.0"};
  }
  std::string phrase(const std::vector<double>& values, const ShapeValues& shape,
                     JointType type) const override {
    const std::string stiffness =
        shape[0] == 0.0 ? parameter_text(*this, values, 0, type) : text_with_unit(values[0], "N/m");
    return "a spring of " + stiffness;
  }
};

}  // namespace

const Effect& joint_spring() {
  static const JointSpring kEffect;
  return kEffect;
}

}  // namespace veridyn
