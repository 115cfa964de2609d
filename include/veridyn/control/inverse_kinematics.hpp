#pragma once

#include "veridyn/control/task_inverse.hpp"
#include "veridyn/control/tip_kinematics.hpp"

namespace veridyn {

enum class ReachStatus {
  kReached,
  kNotReached,  ///< out of reach, beyond the joints' limits, or not reachable from this start
  // Closed forms know more.
  kOutsideLimits,  ///< reached, but at least one joint is outside of its limits
  kSingular,       ///< reached; the pose does not determine some joints
  kOutOfReach
};

/// The status as text: "not reached".
const char* name_of(ReachStatus status);

struct InverseKinematicsOptions {
  TaskRows rows = TaskRows::kPosition;
  double position_tolerance = 1e-7;  ///< [m] bound of |p_d - p|
  double angle_tolerance = 1e-7;     ///< [rad] bound of the angle of R_d R'
  int most_iterations = 60;
  /// Largest change of a joint per iteration [rad]; of a prismatic joint in characteristic lengths.
  double longest_step = 0.4;
  TaskInverseOptions inverse{0.0, 0.02};
};

/// Joint positions for a pose of the tip, on any arm, within the limits of its file: Newton steps through
/// TaskInverse, shortened until the error decreases; joints that would leave their limits stay there while
/// the others continue. The run time is bounded and nothing is allocated, so that a control loop can start
/// from its last positions. Among many solutions it finds one near the start.
///
///   InverseKinematics inverse(arm, {"tool"});
///   if (inverse.solve(position, rotation, q) == ReachStatus::kReached) ...   // q: start, then result
class InverseKinematics {
 public:
  /// @throws InvalidInput  as TaskInverse; tolerances or steps that are not above zero.
  InverseKinematics(const Model& arm, const Tip& tip, const InverseKinematicsOptions& options = {});

  /// @param position, R_world_tip  of the tip, in the world; the rotation is used for poses only.
  /// @param q  (n) initial guess, overwritten with the best positions found, within limits.
  ReachStatus solve(const Eigen::Vector3d& position, const Eigen::Matrix3d& R_world_tip,
                    VectorXd& q) noexcept;

  int iterations() const { return iterations_; }             ///< Iterations of the last solve()
  /// [m] remaining after the last solve()
  double position_error() const { return position_error_; }
  double angle_error() const { return angle_error_; }  ///< [rad] remaining after the last solve()

 private:
  double measure(const Eigen::Vector3d& position, const Eigen::Matrix3d& R, const VectorRef& q,
                 Vector6d& e) noexcept;  ///< sets e and both errors; @returns one number for both
  void step(const Vector6d& e, const VectorRef& q) noexcept;  ///< sets move_ to a damped step of at most longest_step
  bool reached() const;  ///< both errors are within their tolerances

  InverseKinematicsOptions options_;
  TipKinematics kinematics_;
  TaskInverse inverse_;
  VectorXd lower_, upper_, unit_, rest_, move_, trial_;
  int iterations_ = 0;
  double position_error_ = 0.0, angle_error_ = 0.0;
};

}  // namespace veridyn
