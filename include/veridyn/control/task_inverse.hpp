#pragma once

#include <algorithm>
#include <vector>

#include "veridyn/control/tip_kinematics.hpp"
#include "veridyn/math/types.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// Which rows of a task count: the tip's position alone, or its orientation too.
enum class TaskRows { kPosition = 3, kPose = 6 };

struct TaskInverseOptions {
  /// [m] by which metres and radians compare; 0: the arm's own, see characteristic_length().
  double length = 0.0;
  /// A singular value of the normalised Jacobian below this is taken for this much: the inverse
  /// never asks for more than 1 / threshold normalised units of joint motion per unit of the task.
  double threshold = 0.05;
};

/// The root mean square distance from which turning coordinates move the tip, in the middle of
/// their ranges [m]; 1 if there is none.
double characteristic_length(const Model& arm, const Tip& tip);

/// Solves J y = a for joint accelerations or velocities, near singularities and for Jacobians that
/// mix units.
///
/// The Jacobian of a revolute-revolute-prismatic arm holds metres per radian beside metres per
/// metre: its singular values mean nothing as they are. Here metres are counted in characteristic
/// lengths L on both sides,
///
///   J~ = W_x J W_q,   W_x = 1/L on linear rows,   W_q = L on prismatic columns
///
/// and the inverse of J~ = U S V' is damped direction by direction,
///
///   J# = W_q V diag(s_i / max(s_i, threshold)^2) U' W_x
///
/// which is the pseudo-inverse away from singularities, continuous, and still at rest in the lost
/// direction of a singular pose. What J# leaves free, a posture y0 takes, damped directions
/// included:
///
///   y = J# a + W_q (1 - J~# J~) W_q^-1 y0
///
/// Source: damped least squares with numerical filtering, Maciejewski and Klein, J. Robotic Systems
/// 5(6), 1988; the choice of damping is ours. Nothing allocates after the constructor.
///
///   TaskInverse inverse(arm, {"tool"}, TaskRows::kPosition);
///   inverse.update(tip.jacobian());
///   inverse.solve(a, y0, y);
class TaskInverse {
 public:
  /// @throws InvalidInput  a length or threshold below zero, a threshold of zero.
  TaskInverse(const Model& arm, const Tip& tip, TaskRows rows,
              const TaskInverseOptions& options = {});

  /// Factors J, (rows x n) or (6 x n), of which the first rows are used.
  /// Sizes are those of the constructor; another one is a fault of the program, asserted in debug
  /// builds alone.
  void update(const MatrixXd& J) noexcept;

  /// y (n) from a (first `rows` entries used) and a posture y0 (n).
  void solve(const Vector6d& a, const VectorXd& y0, VectorXd& y) noexcept;

  /// The wrench that joint torques balance, J' h = tau in the least squares sense: h = J#' tau,
  /// first `rows` entries; in lost directions it stays small, not large. Entries beyond are zero.
  void solve_wrench(const VectorXd& tau, Vector6d& h) noexcept;

  /// Holds coordinate i: its column counts as zero from the next update() on, until release().
  void hold(int i) noexcept { held_[static_cast<size_t>(i)] = 1; }
  void release() noexcept { std::fill(held_.begin(), held_.end(), char{0}); }
  bool held(int i) const noexcept { return held_[static_cast<size_t>(i)] != 0; }

  int rows() const { return rows_; }
  double length() const { return length_; }
  /// The smallest singular value of J~ at the last update().
  double smallest_singular_value() const { return smallest_; }
  bool near_singular() const { return smallest_ < threshold_; }

 private:
  template <int kRows>
  void factor() noexcept;
  Vector6d weigh(const Vector6d& a) const noexcept;

  int rows_;
  double length_, threshold_;
  double smallest_ = 0.0;
  VectorXd unit_;  // W_q
  std::vector<char> held_;
  MatrixXd J_;                     // J~, (rows x n)
  Eigen::Matrix<double, 6, 6> U_;  // left singular vectors
  Vector6d gain_;                  // 1 / max(s, threshold)^2
};

}  // namespace veridyn
