#pragma once

#include <algorithm>
#include <vector>

#include "veridyn/control/tip_kinematics.hpp"
#include "veridyn/math/types.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// Rows of a task: the tip's position alone, or its orientation too.
enum class TaskRows { kPosition = 3, kPose = 6 };

struct TaskInverseOptions {
  /// [m] length at which one metre weighs as much as one radian; 0: characteristic_length() of the arm.
  double length = 0.0;
  /// Singular values of the normalised Jacobian below this are raised to it: the inverse never gives more
  /// than 1 / threshold normalised units of joint motion for one unit of the task.
  double threshold = 0.05;
};

/// Root mean square distance [m] of the tip from the axes of the revolute coordinates, at the
/// middle of their ranges; 1 without such coordinates.
double characteristic_length(const Model& arm, const Tip& tip);

/// Solves J y = a for joint accelerations or velocities, robustly near singularities and for
/// Jacobians that mix units.
///
/// The Jacobian of a revolute-revolute-prismatic arm holds metres per radian beside metres per metre, so its
/// singular values depend on the units. Here metres are divided by the characteristic length L on both sides,
///
///   J~ = W_x J W_q,   W_x = 1/L on linear rows,   W_q = L on prismatic columns
///
/// and the inverse of J~ = U S V' is damped direction by direction,
///
///   J# = W_q V diag(s_i / max(s_i, threshold)^2) U' W_x
///
/// which is the pseudo-inverse away from singularities, continuous, and zero in the singular direction of a
/// singular pose. A posture y0, a desired joint motion, is projected onto the null space of J#, damped
/// directions included:
///
///   y = J# a + W_q (1 - J~# J~) W_q^-1 y0
///
/// Source: damped least squares with numerical filtering, Maciejewski and Klein, J. Robotic Systems
/// 5(6), 1988, with another choice of damping. Nothing allocates after the constructor.
///
///   TaskInverse inverse(arm, {"tool"}, TaskRows::kPosition);
///   inverse.update(tip.jacobian());
///   inverse.solve(a, y0, y);
class TaskInverse {
 public:
  /// @throws InvalidInput  a length below zero, or a threshold that is not above zero.
  TaskInverse(const Model& arm, const Tip& tip, TaskRows rows,
              const TaskInverseOptions& options = {});

  /// Factors J, (rows x n), or (6 x n) of which the first rows are used.
  /// Vectors have the sizes of the constructor; debug builds assert it.
  void update(const MatrixXd& J) noexcept;

  /// Computes y (n) from a (first `rows` entries used) and a posture y0 (n).
  void solve(const Vector6d& a, const VectorRef& y0, VectorXd& y) noexcept;

  /// The wrench that balances joint torques, J' h = tau in the least-squares sense: h = J#' tau, first `rows`
  /// entries; it remains small in singular directions. Other entries are zero.
  void solve_wrench(const VectorRef& tau, Vector6d& h) noexcept;

  /// Holds coordinate i: from the next update() on its column counts as zero, until release().
  void hold(int i) noexcept { held_[i] = 1; }
  void release() noexcept { std::fill(held_.begin(), held_.end(), char{0}); }
  bool held(int i) const noexcept { return held_[i] != 0; }  ///< true: joint i does not contribute, see hold()

  int rows() const { return rows_; }
  double length() const { return length_; }
  /// The smallest singular value of J~ at the last update(); computed anew by every call.
  double smallest_singular_value() const noexcept;
  /// True if the smallest singular value is not above the threshold, so that a direction is damped.
  bool near_singular() const { return near_singular_; }

 private:
  template <int kRows>
  void factor() noexcept;  ///< factors J~ J~'
  Vector6d weigh(const Vector6d& a) const noexcept;  ///< (J~ J~')^-1 a, damped

  int rows_;
  double length_, threshold_;
  bool near_singular_ = true;
  VectorXd unit_;  // W_q
  std::vector<char> held_;
  MatrixXd J_;                     // J~, (rows x n)
  /// The lower Cholesky factor of J~ J~' with the inverse of its diagonal; near a singularity the
  /// left singular vectors.
  Eigen::Matrix<double, 6, 6> U_;
  Vector6d gain_;  // 1 / max(s, threshold)^2 of those vectors
};

}  // namespace veridyn
