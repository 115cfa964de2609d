#pragma once

#include <Eigen/Core>

#include "veridyn/control/cooperative_controller.hpp"

namespace veridyn {

struct TeleoperationOptions {
  Eigen::Matrix3d R_follower_leader{Eigen::Matrix3d::Identity()};  ///< of motions and forces
  double scale = 0.5;         ///< motion of the follower per motion of the leader
  double force_scale = 1.0;   ///< force at the leader's tip per force at the follower's; 0: none
  double largest_force = 5.0;  ///< [N] that the leader's hand feels at most
  double damping = 4.0;       ///< [N s/m] at the leader's tip while the clutch is in
  double speed = 0.2;         ///< [m/s] of the follower at most
  double cutoff = 30.0;       ///< [Hz] of the low-pass of forces on their way back
  double ramp = 0.1;          ///< [s] in which forces come back after the clutch went in
  double period = 1e-3;       ///< [s] of update()
};

/// A leader's tip leads a follower's, and the follower's force comes back to the leader's:
///
///   x_f = x_f0 + s R (x_l - x_l0)       0: where the clutch went in
///   f_l = -k R' f_f - d dx_l/dt         f_f: of the follower's tip on what it touches
///
/// While the clutch is out the follower stays where it is and the leader is free. Nothing jumps when
/// it goes in: positions are relative to that moment, and forces come back over `ramp`.
///
/// Nothing allocates or throws after the constructor.
class Teleoperation {
 public:
  /// @param leader, follower  where the tips are [m].
  /// @throws InvalidInput  options that cannot be.
  Teleoperation(const TeleoperationOptions& options, const Eigen::Vector3d& leader,
                const Eigen::Vector3d& follower);

  /// The clutch goes in or out with the next update().
  void clutch(bool in) noexcept { wanted_in_ = in; }
  bool in() const { return in_; }

  /// @param leader, velocity  of the leader's tip [m], [m/s]. @param force  f_f [N].
  void update(const Eigen::Vector3d& leader, const Eigen::Vector3d& velocity,
              const Eigen::Vector3d& force) noexcept;

  const TipTarget& follower() const { return target_; }           ///< where the follower shall be
  const Eigen::Vector3d& leader_force() const { return back_; }  ///< f_l [N]

 private:
  TeleoperationOptions options_;
  TipTarget target_;
  Eigen::Vector3d leader_start_, follower_start_, filtered_{Eigen::Vector3d::Zero()},
      back_{Eigen::Vector3d::Zero()};
  double share_ = 0.0, since_ = 0.0;
  bool in_ = false, wanted_in_ = false;
};

}  // namespace veridyn
