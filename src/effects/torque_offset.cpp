#include "phrase.hpp"
#include "registry.hpp"
#include "effects/written_in_c.hpp"

namespace veridyn {
namespace {

/// tau = offset: the zero of the torque measurement, or different friction in the two directions;
/// one recording of motion cannot separate the two (seed errata on thesis 4.13).
class TorqueOffset final : public AxisEffect, public WrittenInC {
 public:
  std::string name() const override { return "torque_offset"; }
  std::vector<EffectParameter> parameters() const override {
    return {{"offset", "N m", "N", ParameterSign::kAny}};
  }
  EffectTraits traits(const ShapeValues& /*shape*/) const override {
    EffectTraits t;
    t.affine = true;
    t.holds_at_rest = true;
    t.elementary = true;
    t.urdf_attribute = "offset";
    return t;
  }
  void columns(const AxisSample& /*x*/, const ShapeValues& /*shape*/, EffectState& /*state*/,
               EffectColumns& row) const noexcept override {
    row[0] = 1.0;
  }
  std::vector<std::string> c_columns(const ShapeValues& /*shape*/) const override {
    return {"1.0"};
  }
  std::string phrase(const std::vector<double>& values, const ShapeValues& /*shape*/,
                     JointType type) const override {
    return "a constant " + effort_word(type) + " of " + parameter_text(*this, values, 0, type);
  }
};

}  // namespace

const Effect& torque_offset() {
  static const TorqueOffset kEffect;
  return kEffect;
}

}  // namespace veridyn
