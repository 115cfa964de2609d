#pragma once

#include "veridyn/control/task_inverse.hpp"
#include "veridyn/control/tip_kinematics.hpp"
#include "veridyn/math/types.hpp"

namespace veridyn {

/// Roll, pitch, yaw [rad] of R = Rz(yaw) Ry(pitch) Rx(roll), pitch within +-pi/2.
Eigen::Vector3d roll_pitch_yaw(const Eigen::Matrix3d& R) noexcept;

/// The rotation Rz(yaw) Ry(pitch) Rx(roll).
Eigen::Matrix3d rotation_of(const Eigen::Vector3d& roll_pitch_yaw) noexcept;

/// omega = T(angles) d(angles)/dt, written in the frame that the angles refer to.
Eigen::Matrix3d angle_rates_to_omega(const Eigen::Vector3d& roll_pitch_yaw) noexcept;

/// The time derivative dT/dt of angle_rates_to_omega(), from the angles [rad] and their rates [rad/s].
Eigen::Matrix3d angle_rates_to_omega_rate(const Eigen::Vector3d& roll_pitch_yaw,
                                          const Eigen::Vector3d& rates) noexcept;

/// The tip's motion in the coordinates of thesis 7.3: x = [position; roll, pitch, yaw], where the
/// angles are those of R_home' R_world_tip, and
///
///   dx = J_a dq,   J_a = T_A^-1 J,   T_A = diag(1, R_home T(angles)),   h_a = T_A' h
///
/// T is singular at a pitch of +-90 degrees from home: choose home near the middle of the
/// workspace. Within 3 degrees of the singularity the inverse is damped, like TaskInverse's. With
/// TaskRows::kPosition only the first three rows are filled and J_a = J. Nothing allocates after
/// the constructor.
///
///   AnalyticalTask task(6, TaskRows::kPose, R_world_home);
///   task.update(state.tip());   // then task.x(), task.jacobian(), task.wrench(h)
class AnalyticalTask {
 public:
  /// @param home  R_world_home. @throws InvalidInput  home is not orthonormal.
  AnalyticalTask(int joints, TaskRows rows,
                 const Eigen::Matrix3d& home = Eigen::Matrix3d::Identity());

  /// Computes x, dx, J_a, its rate and T_A from the tip's motion in the world; debug builds assert the number of joints.
  void update(const TipKinematics& tip) noexcept;

  const Vector6d& x() const { return x_; }
  const Vector6d& dx() const { return dx_; }
  const MatrixXd& jacobian() const { return J_; }        ///< J_a, (6 x n)
  const MatrixXd& jacobian_rate() const { return dJ_; }  ///< dJ_a/dt, (6 x n)
  const Eigen::Matrix<double, 6, 6>& T_A() const { return T_A_; }

  /// Converts a wrench [force; moment] about the tip, written in the world, to h_a.
  Vector6d wrench(const Vector6d& h_world) const noexcept;

  /// x_d - x of the last update(), [m] and [rad], with angles wrapped to +-pi.
  Vector6d difference(const Vector6d& x_wanted) const noexcept;

  /// The task coordinates of a pose.
  Vector6d coordinates(const Eigen::Vector3d& position,
                       const Eigen::Matrix3d& R_world_tip) const noexcept;

 private:
  TaskRows rows_;
  Eigen::Matrix3d home_;
  Vector6d x_{Vector6d::Zero()}, dx_{Vector6d::Zero()};
  MatrixXd J_, dJ_;
  Eigen::Matrix<double, 6, 6> T_A_{Eigen::Matrix<double, 6, 6>::Identity()};
};

}  // namespace veridyn
