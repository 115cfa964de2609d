#pragma once

#include "veridyn/control/arm_state.hpp"
#include "veridyn/math/types.hpp"

namespace veridyn {

struct ModelErrorOptions {
  double bandwidth = 10.0;  ///< [1/s]
  VectorXd limit;           ///< (n) largest torque that it adds [N m], [N], finite
};

/// Integral action within the model: what the arm's acceleration lacks of the one that was asked
/// for is a torque that the model does not know, and it is added,
///
///   d <- d + bandwidth * M(q) (y dt - change of dq),   |d_i| <= limit_i
///
/// a first-order observer of that torque. The same for joint and Cartesian control, gains
/// unchanged: it makes ddq = y true, whatever y asks for, and at rest it raises the torque until
/// friction gives way. What the motors were not sent of the torque asked for (limits of the motors,
/// of the boards, a supervisor that brakes) is no error of the model: sent() takes it out,
///
///   d <- d + bandwidth * (M(q) (y dt - change of dq) - (asked - sent) dt)
///
/// and where a joint was sent less than it was asked for, d grows no further in that direction.
/// Under a contact without a force sensor it pushes with up to `limit` more
/// than the law wants, so the limit is what the model may be wrong by: TorqueUncertainty gives it,
/// cycle by cycle where wanted.
///
///   ModelErrorObserver error(3, {10.0, limit});
///   every cycle: tau += error.update(state, control.acceleration(), 0.001);
///                error.sent(tau, within_limits);  // where anything lies between tau and the motors
class ModelErrorObserver {
 public:
  /// @throws InvalidInput  limits that are not `joints` finite numbers, none below zero; a
  ///                       bandwidth that is not above zero.
  ModelErrorObserver(int joints, const ModelErrorOptions& options);

  /// @param y  (n) acceleration that the motors were told to make from now on. @param dt [s] since
  /// the last update(). @returns d (n), to be added to the torque; as it was where a number is
  /// none.
  /// Sizes are those of the constructor; another one is a fault of the program, asserted in debug
  /// builds alone.
  const VectorXd& update(const ArmState& arm, const VectorXd& y, double dt) noexcept;

  /// After update(), as often as there is something new to say about its cycle.
  /// @param asked  (n) torque with which the arm would make y. @param sent  (n) torque that the
  /// motors were sent, after every limit. Without a call they are the same.
  void sent(const VectorXd& asked, const VectorXd& sent) noexcept;

  /// Other limits from the next update() on; those that could not be are refused: false.
  bool set_limit(const VectorXd& limit) noexcept;

  /// Forgets everything: after a fault, or before the motors are switched on.
  void reset() noexcept;

  const VectorXd& torque() const { return d_; }

 private:
  ModelErrorOptions options_;
  VectorXd d_, y_, dq_, lacking_, step_, not_sent_;
  bool first_ = true;
};

}  // namespace veridyn
