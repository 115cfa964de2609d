#include "phrase.hpp"
#include "registry.hpp"
#include "effects/written_in_c.hpp"

namespace veridyn {
namespace {

/// tau = coefficient * ds.
class ViscousFriction final : public AxisEffect, public WrittenInC {
 public:
  std::string name() const override { return "viscous_friction"; }
  std::vector<EffectParameter> parameters() const override {
    return {{"coefficient", "N m s/rad", "N s/m", ParameterSign::kNonnegative}};
  }
  EffectTraits traits(const ShapeValues& /*shape*/) const override {
    EffectTraits t;
    t.role = EffectRole::kFriction;
    t.uses_velocity = true;
    t.affine = true;
    t.elementary = true;
    t.mixed_axes = true;
    t.urdf_attribute = "damping";
    return t;
  }
  void columns(const AxisSample& x, const ShapeValues& /*shape*/, EffectState& /*state*/,
               EffectColumns& row) const noexcept override {
    row[0] = x.ds;
  }
  std::vector<std::string> c_columns(const ShapeValues& /*shape*/) const override {
    return {"ds"};
  }
  std::string phrase(const std::vector<double>& values, const ShapeValues& /*shape*/,
                     JointType type) const override {
    return parameter_text(*this, values, 0, type) + " of viscous friction";
  }
};

}  // namespace

const Effect& viscous_friction() {
  static const ViscousFriction kEffect;
  return kEffect;
}

}  // namespace veridyn
