#include "motion_check.hpp"

#include <algorithm>
#include <cmath>

#include "veridyn/math/numbers.hpp"
#include "set_points.hpp"
#include "veridyn/math/require.hpp"

namespace veridyn::dvrk {
namespace {

// Margin of a range for tracking errors: the supervisor checks the actual position, not the
// reference.
constexpr double kRoom = 0.0025;

// [rad], [m]; infinite where the configuration has none.
PositionRange soft_limits(const ActuatorConfig& actuator) {
  if (!(actuator.lower < actuator.upper)) return {-kInfinity, kInfinity};
  return {actuator.lower, actuator.upper};
}

}  // namespace

MotionCheck::MotionCheck(const ArmSession& arm, const MotionController& controller,
                         Eigen::Index joints)
    : arm_(arm.robot().name), braking_(controller.limits().braking) {
  const MotionLimits limits = controller.limits();
  const auto n = static_cast<Eigen::Index>(arm.joints());
  for (Eigen::Index j = 0; j < std::min(joints, limits.lower.size()); ++j)
    guards_.push_back({text("joint ", limits.names[j]),
                       "limits of the robot file",
                       VectorXd::Unit(n, j),
                       {limits.lower[j], limits.upper[j]},
                       limits.velocity[j]});
  const MatrixXd& to_actuator = arm.units().joint_to_actuator();
  for (int i = 0; i < arm.joints(); ++i) {
    const PositionRange range = soft_limits(arm.robot().actuators[i]);
    actuators_.push_back(range);
    const VectorXd row = to_actuator.row(i).transpose();
    // The position of an actuator that joints beyond the motion move as well is unknown.
    if (row.head(joints).isZero() || !row.tail(n - joints).isZero()) continue;
    guards_.push_back({text("actuator ", i), "soft limits", row, range, kInfinity});
  }
}

const MotionCheck::Guard* MotionCheck::violated_guard(const VectorXd& q, const VectorXd& dq,
                                                 double share_left) const noexcept {
  for (const Guard& guard : guards_) {
    const double at = guard.of_joints.dot(q), speed = guard.of_joints.dot(dq);
    const double span = guard.range.upper - guard.range.lower;
    const double room = std::isfinite(span) ? share_left * span : 0.0;
    if (!(std::abs(speed) <= guard.velocity) ||
        leaves_range(at, speed, {guard.range.lower + room, guard.range.upper - room}, braking_))
      return &guard;
  }
  return nullptr;
}

void MotionCheck::require_inside(const MotionSamples& motion, double rate) const {
  SetPoints points(motion);
  const auto n = guards_.empty() ? 0 : guards_.front().of_joints.size();
  JointReference at(static_cast<int>(n));
  const double duration = points.duration();
  const auto steps = static_cast<long>(std::ceil(duration * rate));
  for (long k = 0; n > 0 && k <= steps; ++k) {
    const double t = std::min(duration, static_cast<double>(k) / rate);
    points.at(t, at);
    const Guard* guard = violated_guard(at.q, at.dq, kRoom);
    if (guard == nullptr) continue;
    const double q = guard->of_joints.dot(at.q), dq = guard->of_joints.dot(at.dq);
    if (std::abs(dq) > guard->velocity)
      throw InvalidInput(text("arm '", arm_, "': the motion moves ", guard->name, " with ", dq,
                              " at ", t, " s, expected at most ", guard->velocity, " (",
                              guard->whose, ")."));
    throw InvalidInput(text("arm '", arm_, "': the motion takes ", guard->name, " to ", q,
                            " with a velocity of ", dq, " at ", t, " s, from where it stops at ",
                            q + dq / braking_, ", expected ", guard->range.lower, " to ",
                            guard->range.upper, " (", guard->whose, ") with ", 100.0 * kRoom,
                            " % of them left; excite --limit-share makes a smaller motion."));
  }
}

std::string MotionCheck::objection_to(const VectorXd& q) const {
  const Guard* guard = violated_guard(q, VectorXd::Zero(q.size()), 0.0);
  if (guard == nullptr) return "";
  return text(guard->name, " stands at ", guard->of_joints.dot(q), ", expected ",
              guard->range.lower, " to ", guard->range.upper, " (", guard->whose,
              "): move it inside by hand");
}

int MotionCheck::leaving_actuator(const BoardArmState& state) const noexcept {
  for (size_t i = 0; i < actuators_.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (leaves_range(state.actuator_q[k], state.actuator_dq[k], actuators_[i], braking_))
      return static_cast<int>(i);
  }
  return -1;
}

}  // namespace veridyn::dvrk
