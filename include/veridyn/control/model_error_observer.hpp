#pragma once

#include "veridyn/control/arm_state.hpp"
#include "veridyn/math/types.hpp"

namespace veridyn {

struct ModelErrorOptions {
  double bandwidth = 10.0;  ///< [1/s]
  VectorXd limit;           ///< (n) largest |torque| that the observer adds [N m], [N], finite
};

/// Integral action through the model: the difference between the commanded and the measured
/// acceleration is a torque that the model does not predict, and the observer adds it,
///
///   d <- d + bandwidth * M(q) (y dt - change of dq),   |d_i| <= limit_i
///
/// a first-order disturbance observer. It is the same for joint and Cartesian control, with unchanged gains:
/// it makes ddq = y, and at rest it increases the torque until friction breaks away. Torque that the motors
/// did not receive (because of limits of motors or boards, or a supervisor that brakes) is no model error;
/// set_sent_torques() subtracts it,
///
///   d <- d + bandwidth * (M(q) (y dt - change of dq) - (asked - sent) dt)
///
/// and if a joint received less torque than requested, d does not grow further in that direction. In a
/// contact without a force sensor the observer adds up to `limit` to the force of the law, so that the limit
/// should be the uncertainty of the model: TorqueUncertainty computes it, in every cycle if wanted.
///
///   ModelErrorObserver error(3, {10.0, limit});
///   every cycle: tau += error.update(state, control.acceleration(), 0.001);
///                error.set_sent_torques(tau, within_limits);  // if anything limits tau before the motors
class ModelErrorObserver {
 public:
  /// @throws InvalidInput  limits that are not `joints` finite numbers, or one below zero; a
  /// bandwidth that is not above zero.
  ModelErrorObserver(int joints, const ModelErrorOptions& options);

  /// @param y  (n) acceleration that is commanded from now on. @param dt [s] since the last
  /// update(). @returns d (n), to be added to the torque; unchanged if an input is not finite
  /// or dt is below zero.
  /// Vectors have the sizes of the constructor; debug builds assert it.
  const VectorXd& update(const ArmState& arm, const VectorRef& y, double dt) noexcept;

  /// Call it after update(), again whenever the torques of its cycle are known better.
  /// @param asked  (n) torque that would cause y. @param sent  (n) torque that the motors received, after all
  /// limits. Without a call the two are assumed to be equal.
  void set_sent_torques(const VectorRef& asked, const VectorRef& sent) noexcept;

  /// Sets limits for the next update(); false for limits that the constructor would refuse.
  bool set_limit(const VectorRef& limit) noexcept;

  /// Clears the estimate: after a fault, or before the motors are switched on.
  void reset() noexcept;

  const VectorXd& torque() const { return d_; }

  /// (n) torque missing from the law in the last cycle: d of the previous update(), plus the torque that was
  /// missing in spite of it, M(q) (y - change of dq / dt), with the noise of the velocities. For estimators.
  const VectorXd& missing() const { return missing_; }

 private:
  ModelErrorOptions options_;
  VectorXd d_, y_, dq_, lacking_, step_, not_sent_, missing_;
  bool first_ = true;
};

}  // namespace veridyn
