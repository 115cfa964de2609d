#pragma once

#include <optional>
#include <vector>

#include "veridyn/control/arm_state.hpp"
#include "veridyn/control/friction_compensation.hpp"
#include "veridyn/control/task_inverse.hpp"
#include "veridyn/control/torque_uncertainty.hpp"
#include "veridyn/dynamics/rigid_body_dynamics.hpp"

namespace veridyn {

struct MomentumObserverOptions {
  double bandwidth = 30.0;         ///< [1/s]
  UncertaintyOptions uncertainty;  ///< uncertainty of the model, from which the threshold follows
  int cycles = 5;                  ///< cycles in a row above the threshold that make a contact
  TaskInverseOptions inverse;
};

/// Estimates external torques without a force sensor, from the momentum p = M dq alone:
///
///   r = bandwidth (integral of (tau_motor - friction - g - forces + C' dq - r) dt - p + p(0))
///
/// follows the torque J' h that the arm exerts on the world, with a lag of 1 / bandwidth; no acceleration is
/// needed. A contact is detected if |r_i| exceeds the uncertainty of the model in this motion
/// (TorqueUncertainty) for some cycles. It is assigned to a link: a contact causes no torque in the coordinates
/// beyond the touched link. The assigned link is therefore the first that the outermost coordinate with a
/// torque moves; the touched one may lie farther out if the force acts in a direction that causes no torque in
/// the joints between. Source: De Luca and Mattone, ICRA 2005.
/// Nothing allocates after the constructor.
///
///   MomentumObserver touch(arm, {"tool"});
///   every cycle: touch.update(state, tau_of_last_cycle, control.acceleration(), 0.001);
///   if (touch.contact()) ...   // touch.frame(), touch.force()
class MomentumObserver {
 public:
  /// @throws InvalidInput  as ArmState and TorqueUncertainty; a bandwidth or number of cycles that
  ///                       is not above zero.
  MomentumObserver(const Model& arm, const Tip& tip, const MomentumObserverOptions& options = {});

  /// @param tau_motor  (n) true torques since the last update(), preferably as commanded; measured ones are
  /// late by JointSensors::torque_delay(), which delays the estimate. @param ddq  (n) wanted, for the
  /// threshold. @param dt  [s] since the last update(). @returns r (n) [N m], [N]; it restarts if a number is
  /// not finite or dt is below zero.
  /// Vectors have the sizes of the constructor; debug builds assert it.
  const VectorXd& update(const ArmState& arm, const VectorRef& tau_motor, const VectorRef& ddq,
                         double dt) noexcept;

  void reset() noexcept;  ///< sets r, threshold and force to zero, ends a contact, and restarts with the next update()

  const VectorXd& torque() const { return r_; }             ///< r
  const VectorXd& threshold() const { return threshold_; }  ///< (n)

  /// The force [N] at the tip, in the world, that would explain r.
  Eigen::Vector3d force() const { return wrench_.head<3>(); }

  bool contact() const { return coordinate_.has_value(); }
  /// The outermost coordinate whose torque is above its threshold; nullopt: no contact.
  std::optional<JointIndex> coordinate() const {
    return coordinate_ ? std::optional(JointIndex{*coordinate_}) : std::nullopt;
  }
  /// The touched frame; nullopt: no contact, or that coordinate moves no frame with a body.
  std::optional<FrameIndex> frame() const {
    return coordinate_ && frames_[*coordinate_] >= 0 ? std::optional(FrameIndex{frames_[*coordinate_]}) : std::nullopt;
  }

 private:
  MomentumObserverOptions options_;
  RigidBodyDynamics dynamics_;
  FrictionCompensation friction_;
  TorqueUncertainty uncertainty_;
  TaskInverse inverse_;
  std::vector<int> frames_;  // for each coordinate the first frame with a body that it moves
  std::vector<int> order_;   // coordinates from the tip inwards
  VectorXd r_, gradient_, threshold_, sum_, p_, p_start_, none_;
  Vector6d wrench_{Vector6d::Zero()};
  std::vector<int> above_;
  std::optional<int> coordinate_ = {};
  bool first_ = true;
};

}  // namespace veridyn
