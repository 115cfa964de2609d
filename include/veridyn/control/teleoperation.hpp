#pragma once

#include <Eigen/Core>

#include "veridyn/control/cooperative_controller.hpp"

namespace veridyn {

struct TeleoperationOptions {
  /// Rotation applied to motions and forces.
  Eigen::Matrix3d R_follower_leader{Eigen::Matrix3d::Identity()};
  double scale = 0.5;         ///< motion of the follower per motion of the leader
  double force_scale = 1.0;   ///< force at the leader's tip per force at the follower's; 0: none
  double largest_force = 5.0;  ///< [N] largest force reflected to the leader
  double damping = 4.0;       ///< [N s/m] damping of the leader's tip while the clutch is engaged
  double speed = 0.2;         ///< [m/s] largest speed of the follower
  double cutoff = 30.0;       ///< [Hz] low-pass of the reflected forces
  double ramp = 0.1;          ///< [s] fade-in time of reflected forces after the clutch engages
  double period = 1e-3;       ///< [s] interval between calls of update()
};

/// Bilateral teleoperation: the follower's tip follows the leader's, and its force is reflected back:
///
///   x_f = x_f0 + s R (x_l - x_l0)       0: positions when the clutch engaged
///   f_l = -k R' f_f - d dx_l/dt         f_f: force of the follower's tip on the environment
///
/// While the clutch is disengaged the follower holds its position and the leader is free. Engaging
/// causes no jump: positions are relative to that instant, and forces fade in over `ramp`.
///
/// Nothing allocates or throws after the constructor.
class Teleoperation {
 public:
  /// @param leader, follower  initial positions of the tips [m].
  /// @throws InvalidInput  options out of range.
  Teleoperation(const TeleoperationOptions& options, const Eigen::Vector3d& leader,
                const Eigen::Vector3d& follower);

  /// Engages or disengages the clutch with the next update().
  void clutch(bool in) noexcept { wanted_in_ = in; }
  bool is_engaged() const { return in_; }

  /// @param leader, velocity  position and velocity of the leader's tip [m], [m/s]. @param force
  /// f_f [N].
  void update(const Eigen::Vector3d& leader, const Eigen::Vector3d& velocity,
              const Eigen::Vector3d& force) noexcept;

  const TipTarget& follower() const { return target_; }           ///< reference of the follower
  const Eigen::Vector3d& leader_force() const { return back_; }  ///< f_l [N], the force reflected to the leader

 private:
  TeleoperationOptions options_;
  TipTarget target_;
  Eigen::Vector3d leader_start_, follower_start_, filtered_{Eigen::Vector3d::Zero()},
      back_{Eigen::Vector3d::Zero()};
  double share_ = 0.0, since_ = 0.0;
  bool in_ = false, wanted_in_ = false;
};

}  // namespace veridyn
