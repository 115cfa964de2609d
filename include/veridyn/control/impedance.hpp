#pragma once

#include "veridyn/control/analytical_task.hpp"
#include "veridyn/control/arm_state.hpp"
#include "veridyn/control/task_inverse.hpp"

namespace veridyn {

/// Diagonals of M_d, K_d, K_p along x, y, z and, for a pose, roll, pitch, yaw: [kg], [N s/m],
/// [N/m], and [kg m^2], [N m s/rad], [N m/rad]. Position tasks use the first three.
struct ImpedanceGains {
  Vector6d mass{Vector6d::Ones()};
  Vector6d damping{Vector6d::Zero()};
  Vector6d stiffness{Vector6d::Zero()};
};

/// Reference of the tip, in the coordinates of AnalyticalTask.
struct TaskReference {
  Vector6d x{Vector6d::Zero()};
  Vector6d dx{Vector6d::Zero()};
  Vector6d ddx{Vector6d::Zero()};
};

struct ImpedanceOptions {
  TaskRows rows = TaskRows::kPosition;
  Eigen::Matrix3d home{Eigen::Matrix3d::Identity()};  ///< see AnalyticalTask
  TaskInverseOptions inverse;
  /// Posture, (n), towards which the null space of the task is controlled, each joint separately
  /// with damping. Empty: damping alone.
  VectorXd posture;
  double posture_p = 25.0;  ///< [1/s^2]
  double posture_d = 10.0;  ///< [1/s]
};

/// Impedance of the tip in Cartesian space (thesis 7.6 to 7.9):
///
///   y   = J_a# (ddx_d + M_d^-1 (K_p (x_d - x) + K_d (dx_d - dx) - h_a) - dJ_a dq) + posture
///   tau = M(q) y + bias(q, dq) + J' h
///
/// so that the tip obeys M_d (ddx_d - ddx) + K_d (dx_d - dx) + K_p (x_d - x) = h_a. h is the wrench
/// that the tip exerts on the world, as a force sensor between them measures it; h_a = T_A' h.
/// J_a# is TaskInverse's.
///
/// A force measurement with a delay T reduces the damping: with M_x the arm's own mass at the tip and K_e the
/// stiffness of the environment, choose K_d above K_e T (1 - M_d / M_x). The gains of the thesis (3 N s/m,
/// 0.35 kg on a spring of 2450 N/m) leave no margin at 1 kHz; there, friction stabilised the loop. A wanted
/// velocity acts on the force through K_d: if x_d moves only to press harder, leave dx_d at zero. Nothing
/// allocates after the constructor.
///
///   Impedance control(arm, {"tool"}, gains);
///   state.update(q, dq);
///   tau = control.update(state, wanted, wrench);
class Impedance {
 public:
  /// @throws InvalidInput  gains that are not finite or below zero, masses that are not above zero,
  /// a posture of another size; as TaskInverse and AnalyticalTask.
  Impedance(const Model& arm, const Tip& tip, const ImpedanceGains& gains,
            const ImpedanceOptions& options = {});

  /// @param arm  state with the same tip. @param wrench_world  h: [force; moment] about the tip [N,
  /// N m], with zeros for entries that are not measured.
  /// @returns tau (n), valid until the next update().
  /// Vectors have the sizes of the constructor; debug builds assert it.
  const VectorXd& update(const ArmState& arm, const TaskReference& wanted,
                         const Vector6d& wrench_world) noexcept;

  /// y of the last update(), (n).
  const VectorXd& acceleration() const { return y_; }

  /// Joint displacement (n) that the law requires at rest: J_a# (x_d - x - K_p^-1 h_a), where K_p is not zero.
  /// It is an input of FrictionCompensation.
  const VectorXd& joint_error() const { return error_; }

  /// The wanted velocity in joint space, J_a# dx_d (n), an input of FrictionCompensation.
  const VectorXd& joint_velocity() const { return velocity_; }

  /// x, dx, J_a and its rate at the last update().
  const AnalyticalTask& task() const { return task_; }
  const TaskInverse& inverse() const { return inverse_; }

  /// Sets gains for the next update(); false for gains that the constructor would refuse.
  bool set_gains(const ImpedanceGains& gains) noexcept;
  const ImpedanceGains& gains() const { return gains_; }

 private:
  ImpedanceGains gains_;
  ImpedanceOptions options_;
  AnalyticalTask task_;
  TaskInverse inverse_;
  VectorXd y0_, y_, tau_, error_, velocity_, none_;
};

}  // namespace veridyn
