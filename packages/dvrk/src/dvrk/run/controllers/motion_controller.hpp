#pragma once

#include <string>
#include <vector>

#include "veridyn/control/computed_torque.hpp"
#include "dvrk/arms/arm_units.hpp"
#include "veridyn/math/motion_samples.hpp"
#include "veridyn/math/types.hpp"

namespace veridyn::dvrk {

/// Times of a cycle [s].
struct CycleTimes {
  double dt = 0.0;   ///< [s] since the previous cycle with torques
  double age = 0.0;  ///< Largest age of the positions, since the request to the boards
  double age_range = 0.0;  ///< range of the age, since replies came earlier
};

/// Limits of a controller's joints; (m) of its first joints, empty: none.
struct MotionLimits {
  VectorXd lower, upper;  ///< [rad], [m] position limits
  VectorXd velocity;      ///< [rad/s], [m/s] velocity limits
  std::vector<std::string> names;
  double braking = 30.0;  ///< [1/s], see leaves_range()
};

/// Computes the torques of a run. Called while power is on and brakes are open, after every valid
/// read.
class MotionController {
 public:
  virtual ~MotionController() = default;

  /// Clears the controller's state; called in every cycle without power. Neither throws nor
  /// allocates.
  virtual void reset() noexcept = 0;

  /// Called when the arm rests at the first set point and the motion begins.
  virtual void motion_begins() noexcept {}

  /// @param wanted  reference of the joints, (n) of the arm. @param tau  (n), written [N m], [N].
  /// @returns false: the run must end now, see refusal_reason(); tau is then invalid. Never allocates.
  virtual bool torques(const BoardArmState& state, const JointReference& wanted, const CycleTimes& times,
                       VectorXd& tau) noexcept = 0;

  /// Torques (n of the arm) of tau that the motors received after current limits. Neither throws nor
  /// allocates.
  virtual void set_sent_torques(const VectorXd& tau) noexcept { (void)tau; }

  /// Reason for which torques() returned false.
  virtual std::string refusal_reason() const { return ""; }
  /// True if joints are expected near their set points.
  virtual bool follows() const { return true; }
  /// The limits that torques() enforces. A run applies them to the whole motion before power-up.
  virtual MotionLimits limits() const { return {}; }
  /// @throws InvalidInput  this controller would reject the motion later for another reason.
  virtual void require_possible(const MotionSamples& motion) const { (void)motion; }
  /// Converts a motion to positions as measured by the boards, which a run uses: a controller may know errors
  /// of the encoders. torques() and limits() use them too.
  virtual MotionSamples to_board_positions(const MotionSamples& motion) const { return motion; }
};

}  // namespace veridyn::dvrk
