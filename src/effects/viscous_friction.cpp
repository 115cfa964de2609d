#include "phrase.hpp"
#include "registry.hpp"

namespace veridyn {
namespace {

/// tau = coefficient * ds.
class ViscousFriction final : public Effect {
 public:
  std::string name() const override { return "viscous_friction"; }
  std::vector<EffectParameter> parameters() const override {
    return {{"coefficient", "N m s/rad", "N s/m", ParameterSign::kNonnegative}};
  }
  void columns(const AxisSample& x, const ShapeValues& /*shape*/, EffectState& /*state*/,
               EffectColumns& row) const noexcept override {
    row[0] = x.ds;
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
