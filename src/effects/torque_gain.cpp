#include <algorithm>
#include <cmath>

#include "math/digits.hpp"
#include "registry.hpp"
#include "torque_channel.hpp"

namespace veridyn {
namespace {

/// factor >= kLeastFactor: a gain never changes the sign of a torque.
constexpr double kLeastFactor = 0.01;

/// recorded = (1 + error) * true, of one joint's torque: a wrong motor constant, gear ratio or
/// amplifier scale.
///
///   d tau / d error = tau
class TorqueGain final : public TorqueChannel {
 public:
  std::string name() const override { return "torque_gain"; }
  std::vector<EffectParameter> parameters() const override {
    constexpr double kLargest = 0.6;  // largest plausible error
    return {{"error", "1", "1", ParameterSign::kAny, kLargest, kLargest}};
  }
  std::vector<MatrixXd> columns(const ChannelMotion& motion, std::optional<JointIndex> /*joint*/) const override {
    return {motion.effort};
  }
  bool has_rigid_columns() const override { return true; }
  std::vector<RigidColumn> rigid_columns(const Model& arm, std::optional<JointIndex> joint) const override {
    const VectorXd joints = joint ? VectorXd(VectorXd::Unit(arm.joints(), joint->value))
                                  : VectorXd(VectorXd::Ones(arm.joints()));
    return {{arm.gravity(), false, joints}};
  }
  std::vector<InjectedValue> injected(JointType /*type*/) const override {
    return {{"gain", 1.05, 1.0, false}};
  }
  std::string phrase(const std::vector<double>& values, const ShapeValues& /*shape*/,
                     JointType /*type*/) const override {
    return "a recorded torque that is " + digits(100.0 * std::abs(values[0]), 2) + " % too " +
           (values[0] > 0.0 ? "large" : "small");
  }
  void add_to_channel(RecordedChannel& shown, std::optional<JointIndex> /*from*/,
                      const std::vector<double>& values) const override {
    shown.torque_gain *= std::max(1.0 + values[0], kLeastFactor);
  }
  bool scales_torque() const override { return true; }
  bool may_begin_suddenly() const override { return true; }
};

}  // namespace

const Effect& torque_gain() {
  static const TorqueGain kEffect;
  return kEffect;
}

}  // namespace veridyn
