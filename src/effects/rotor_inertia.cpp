#include "phrase.hpp"
#include "registry.hpp"
#include "effects/written_in_c.hpp"

namespace veridyn {
namespace {

/// tau = inertia * dds: the motor's rotor and gears, reflected to the axis.
class RotorInertia final : public AxisEffect, public WrittenInC {
 public:
  std::string name() const override { return "rotor_inertia"; }
  std::vector<EffectParameter> parameters() const override {
    return {{"inertia", "kg m^2", "kg", ParameterSign::kNonnegative}};
  }
  EffectTraits traits(const ShapeValues& /*shape*/) const override {
    EffectTraits t;
    t.role = EffectRole::kInertia;
    t.uses_acceleration = true;
    t.affine = true;
    t.lasting = true;
    t.urdf_attribute = "armature";
    return t;
  }
  void columns(const AxisSample& x, const ShapeValues& /*shape*/, EffectState& /*state*/,
               EffectColumns& row) const noexcept override {
    row[0] = x.dds;
  }
  std::vector<std::string> c_columns(const ShapeValues& /*shape*/) const override {
    return {"dds"};
  }
  std::string phrase(const std::vector<double>& values, const ShapeValues& /*shape*/,
                     JointType type) const override {
    return parameter_text(*this, values, 0, type) + " of reflected rotor inertia";
  }
};

}  // namespace

const Effect& rotor_inertia() {
  static const RotorInertia kEffect;
  return kEffect;
}

}  // namespace veridyn
