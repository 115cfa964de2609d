#include <cmath>

#include "math/digits.hpp"
#include "registry.hpp"

namespace veridyn {
namespace {

constexpr double kStep = 1e-5;  // [rad] or [m] step of the derivative by position

/// A joint's position is recorded with a wrong zero, recorded = true + offset. The torques of all joints depend
/// on it, by those of the rigid bodies:
///
///   d tau / d offset = - d tau / d q_joint
class EncoderOffset final : public SensorError {
 public:
  std::string name() const override { return "encoder_offset"; }
  std::vector<EffectParameter> parameters() const override {
    return {{"offset", "rad", "m", ParameterSign::kAny, 0.2, 0.03}};
  }
  EffectTraits traits(const ShapeValues& /*shape*/) const override {
    EffectTraits t;
    t.role = EffectRole::kSensor;
    t.depends_on_position = true;
    t.same_as_wrong_constant = true;  // this joint's zero in the robot file has the same columns
    t.lasting = true;
    return t;
  }
  bool acts_on(int /*i*/, std::optional<JointIndex> /*joint*/) const override { return true; }
  std::vector<MatrixXd> columns(const ChannelMotion& motion, std::optional<JointIndex> joint) const override {
    MatrixXd q = motion.q;
    MatrixXd below;
    MatrixXd above;
    q.col(joint->value).array() -= kStep;
    motion.bodies.torques(q, motion.dq, motion.ddq, motion.phi, below);
    q.col(joint->value).array() += 2.0 * kStep;
    motion.bodies.torques(q, motion.dq, motion.ddq, motion.phi, above);
    return {(below - above) / (2.0 * kStep)};
  }
  void add_to_channel(RecordedChannel& shown, std::optional<JointIndex> /*from*/,
                      const std::vector<double>& values) const override {
    shown.position_offset += values[0];
  }
  bool may_begin_suddenly() const override { return true; }
  std::vector<InjectedValue> injected(JointType type) const override {
    return {{"offset", type == JointType::kPrismatic ? 0.001 : 0.01, 0.0, false}};
  }
  std::string phrase(const std::vector<double>& values, const ShapeValues& /*shape*/,
                     JointType type) const override {
    return "a recorded position that is " + digits(1e3 * std::abs(values[0]), 3) +
           (type == JointType::kPrismatic ? " mm too " : " mrad too ") +
           (values[0] > 0.0 ? "large" : "small");
  }
};

}  // namespace

const Effect& encoder_offset() {
  static const EncoderOffset kEffect;
  return kEffect;
}

}  // namespace veridyn
