#include <cmath>

#include "math/digits.hpp"
#include "registry.hpp"
#include "torque_channel.hpp"
#include "math/zero_phase_filter.hpp"

namespace veridyn {
namespace {

/// recorded(t) = true(t - seconds), of one joint's torque, as from a filter or a slow channel.
///
///   d tau / d seconds = - d tau / dt
class TimeDelay final : public TorqueChannel {
 public:
  std::string name() const override { return "time_delay"; }
  std::vector<EffectParameter> parameters() const override {
    // [s] The first-order column does not describe longer delays.
    constexpr double kLargest = 0.02;
    return {{"seconds", "s", "s", ParameterSign::kAny, kLargest, kLargest}};
  }
  std::vector<MatrixXd> columns(const ChannelMotion& motion, std::optional<JointIndex> joint) const override {
    MatrixXd out = MatrixXd::Zero(motion.effort.rows(), motion.effort.cols());
    for (Eigen::Index i = 0; i < out.cols(); ++i) {
      if (acts_on(static_cast<int>(i), joint))
        out.col(i) = -differentiate(motion.effort.col(i), motion.dt);
    }
    return {out};
  }
  std::vector<InjectedValue> injected(JointType /*type*/) const override {
    return {{"seconds", 0.004, 0.0, true}};
  }
  std::string phrase(const std::vector<double>& values, const ShapeValues& /*shape*/,
                     JointType /*type*/) const override {
    return "a recorded torque that comes " + digits(1e3 * std::abs(values[0]), 2) + " ms too " +
           (values[0] > 0.0 ? "late" : "early");
  }
  void add_to_channel(RecordedChannel& shown, std::optional<JointIndex> /*from*/,
                      const std::vector<double>& values) const override {
    shown.torque_delay += values[0];
  }
};

}  // namespace

const Effect& time_delay() {
  static const TimeDelay kEffect;
  return kEffect;
}

}  // namespace veridyn
