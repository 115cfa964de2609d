#include "math/digits.hpp"
#include "registry.hpp"
#include "veridyn/effects/channel_effect.hpp"

namespace veridyn {
namespace {

/// The recorded torque of one joint contains a share of another joint's: a common ground of the amplifiers, a
/// strain gauge next to a loaded bearing, a wrong row of a coupling matrix,
///
///   recorded_i = true_i + share * true_from,     d tau_i / d share = tau_from
class TorqueCrosstalk final : public SensorError {
 public:
  std::string name() const override { return "torque_crosstalk"; }
  std::vector<EffectParameter> parameters() const override {
    return {{"share", "1", "1", ParameterSign::kAny}};
  }
  EffectTraits traits(const ShapeValues& /*shape*/) const override {
    EffectTraits t;
    t.role = EffectRole::kSensor;
    t.uses_source = true;
    t.lasting = true;
    return t;
  }
  // Another joint's torque can imitate cables, springs and offsets.
  bool imitates_others() const override { return true; }
  bool acts_on(int i, std::optional<JointIndex> joint) const override { return i == joint->value; }
  std::vector<MatrixXd> columns(const ChannelMotion& motion, std::optional<JointIndex> joint) const override {
    MatrixXd out = MatrixXd::Zero(motion.effort.rows(), motion.effort.cols());
    out.col(joint->value) = motion.effort.col(motion.from->value);
    return {out};
  }
  std::vector<InjectedValue> injected(JointType /*type*/) const override {
    return {{"share", 0.1, 0.0, false}};
  }
  std::string phrase(const std::vector<double>& values, const ShapeValues& /*shape*/,
                     JointType /*type*/) const override {
    return "a recorded torque that contains " + digits(values[0], 3) + " times the torque";
  }
  void add_to_channel(RecordedChannel& shown, std::optional<JointIndex> from,
                      const std::vector<double>& values) const override {
    shown.torque_crosstalk[*from] += values[0];
  }
};

}  // namespace

const Effect& torque_crosstalk() {
  static const TorqueCrosstalk kEffect;
  return kEffect;
}

}  // namespace veridyn
