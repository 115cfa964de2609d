#include <algorithm>
#include <cmath>

#include "effects/written_in_c.hpp"
#include "math/digits.hpp"
#include "phrase.hpp"
#include "registry.hpp"

namespace veridyn {
namespace {

/// A stop or a bumper at one end of the travel: a spring that acts beyond a place and nowhere else,
///
///   tau = side * stiffness * max(0, side * (s - centre) - reach)
///
/// with side = 1 at the upper end and -1 at the lower one; the place is centre + side * reach.
class EndStop final : public AxisEffect, public WrittenInC {
 public:
  std::string name() const override { return "end_stop"; }
  std::vector<EffectParameter> parameters() const override {
    return {{"stiffness", "N m/rad", "N/m", ParameterSign::kNonnegative}};
  }
  std::vector<EffectShape> shapes() const override {
    EffectShape centre{"centre", "rad", "m", 0.0, -10.0, 10.0, false, false};
    centre.scale = ShapeScale::kMiddle;
    EffectShape reach{"reach", "rad", "m", 0.1, 1e-3, 20.0, true, true, 0.01};
    reach.scale = ShapeScale::kTravel;
    reach.grid = {0.15, 0.25, 0.35};
    EffectShape side{"side", "1", "1", 1.0, -1.0, 1.0, false, false};
    side.scale = ShapeScale::kAbsolute;
    side.grid = {1.0, -1.0};
    return {centre, reach, side};
  }
  EffectTraits traits(const ShapeValues& /*shape*/) const override {
    EffectTraits t;
    t.uses_position = true;
    t.depends_on_position = true;
    t.holds_at_rest = true;
    t.lasting = true;
    return t;
  }
  // Any curved force of position can look like a stop.
  bool imitates_others() const override { return true; }
  void columns(const AxisSample& x, const ShapeValues& shape, EffectState& /*state*/,
               EffectColumns& row) const noexcept override {
    row[0] = shape[2] * std::max(0.0, shape[2] * (x.s - shape[0]) - shape[1]);
  }
  std::vector<std::string> c_columns(const ShapeValues& shape) const override {
    const std::string side = c_number(shape[2]);
    return {side + " * fmax(0.0, " + side + " * (s - " + c_number(shape[0]) + ") - " +
            c_number(shape[1]) + ")"};
  }
  std::string phrase(const std::vector<double>& values, const ShapeValues& shape,
                     JointType type) const override {
    return "a stop or bumper of " + parameter_text(*this, values, 0, type) + " at its " +
           (shape[2] > 0.0 ? "upper" : "lower") + " end, from " +
           digits(shape[0] + shape[2] * shape[1], 3) +
           (type == JointType::kPrismatic ? " m" : " rad") + " on";
  }
};

}  // namespace

const Effect& end_stop() {
  static const EndStop kEffect;
  return kEffect;
}

}  // namespace veridyn
