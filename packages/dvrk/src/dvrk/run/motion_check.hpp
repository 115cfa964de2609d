#pragma once

#include <string>
#include <vector>

#include "veridyn/control/computed_torque.hpp"
#include "veridyn/control/safety/position_limit.hpp"
#include "dvrk/run/arm_session.hpp"
#include "dvrk/run/controllers/motion_controller.hpp"
#include "veridyn/math/motion_samples.hpp"

namespace veridyn::dvrk {

/// Limits of a run: those of the controller's joints, and the soft limits of the actuators.
/// leaves_range() tests a motion before power-up and the arm during the run.
class MotionCheck {
 public:
  /// @param joints  number of joints in the motion, the first ones of the arm.
  MotionCheck(const ArmSession& arm, const MotionController& controller, Eigen::Index joints);

  /// @param rate  [Hz] of the set points. @throws InvalidInput  a set point leaves the limits, with the time, the
  ///                       joint or actuator, where it would stop, and its range.
  void require_inside(const MotionSamples& motion, double rate) const;

  /// Reason for which an arm cannot begin here; empty if it can.
  std::string objection_to(const VectorXd& q) const;

  /// The actuator of a moving arm that will leave its soft limits; -1: none. Does not allocate.
  int leaving_actuator(const BoardArmState& state) const noexcept;

 private:
  struct Guard {
    std::string name;
    const char* whose;   ///< owner of the limits
    VectorXd of_joints;  ///< (n) row: maps joint positions to the guarded position
    PositionRange range;
    double velocity;  ///< [rad/s] or [m/s] largest velocity
  };
  /// The first limit that is violated, with `share_left` of its range kept free at either end; nullptr: none.
  const Guard* violated_guard(const VectorXd& q, const VectorXd& dq, double share_left) const noexcept;

  std::string arm_;
  double braking_;
  std::vector<Guard> guards_;
  std::vector<PositionRange> actuators_;  ///< soft limits; infinite where there is none
};

}  // namespace veridyn::dvrk
