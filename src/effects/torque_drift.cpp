#include "phrase.hpp"
#include "registry.hpp"

namespace veridyn {
namespace {

/// tau = rate * time: a torque that grows during the recording, as from warming current sensors.
/// Time counts from the start of the recording; its initial value is torque_offset.
class TorqueDrift final : public AxisEffect {
 public:
  std::string name() const override { return "torque_drift"; }
  std::vector<EffectParameter> parameters() const override {
    return {{"rate", "N m/s", "N/s", ParameterSign::kAny}};
  }
  EffectTraits traits(const ShapeValues& /*shape*/) const override {
    EffectTraits t;
    t.depends_on_time = true;
    return t;
  }
  void columns(const AxisSample& x, const ShapeValues& /*shape*/, EffectState& /*state*/,
               EffectColumns& row) const noexcept override {
    row[0] = x.time;
  }
  std::string phrase(const std::vector<double>& values, const ShapeValues& /*shape*/,
                     JointType type) const override {
    return "a " + effort_word(type) + " that drifts by " + effort_text(60.0 * values[0], type) +
           " per minute";
  }
};

}  // namespace

const Effect& torque_drift() {
  static const TorqueDrift kEffect;
  return kEffect;
}

}  // namespace veridyn
