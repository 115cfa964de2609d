#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <string>
#include <vector>

#include "veridyn/control/inverse_kinematics.hpp"
#include "veridyn/math/types.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// Conditioning of the tip's Jacobian at a posture. Its angular rows are unchanged, its prismatic
/// columns and linear rows are divided by the arm's characteristic_length().
struct Conditioning {
  double condition = 0.0;  ///< largest singular value divided by the smallest; infinite: singular
  double smallest = 0.0;        ///< smallest singular value
  double manipulability = 0.0;  ///< product of the singular values (Yoshikawa 1985)
};

/// One row: joints, the tip's pose, and derived quantities.
struct KinematicRow {
  double time = 0.0;
  VectorXd q;                                             ///< (n)
  Eigen::Isometry3d T_world_tip = Eigen::Isometry3d::Identity();
  MatrixXd jacobian;                                      ///< (6 x n), linear rows first, world
  Conditioning position, pose;                            ///< conditioning of the first three rows, and of all six
  ReachStatus status = ReachStatus::kReached;             ///< status of inverse kinematics
  double position_error = 0.0, angle_error = 0.0;         ///< [m], [rad] remaining errors
  std::vector<std::string> outside;  ///< joints outside the robot file's limits
};

/// The way in which the rows of a table were computed; the last two solve for poses.
enum class KinematicSolver { kForward, kWorkspace, kClosedForm, kNewton };

/// "forward", "workspace", "closed form", "Newton".
const char* name_of(KinematicSolver solver);

struct KinematicTable {
  std::string robot, frame;
  KinematicSolver solver = KinematicSolver::kForward;
  std::vector<std::string> joints;
  std::vector<bool> prismatic;
  std::vector<Limits> limits;  ///< limits of the robot file
  bool has_time = false, has_orientation = true;
  std::vector<KinematicRow> rows;
  bool is_inverse() const { return solver >= KinematicSolver::kClosedForm; }  ///< the rows solve for poses
  int unreached() const;  ///< number of rows whose pose was not reached
  /// The joints that are outside of their limits in some row, each with the first such value and its limits;
  /// empty if there are none.
  std::string outside_words() const;
  std::string report() const;
};

/// Computes poses, Jacobians and conditioning of given joint positions, (rows x n).
/// @throws InvalidInput  no such frame, rows of another size, numbers that are not finite.
KinematicTable forward_kinematics(const Model& arm, const std::string& frame,
                                  const MatrixXd& joints);

/// Solves for a pose; `q` starts at the previous row.
using InverseSolver =
    std::function<ReachStatus(const Eigen::Isometry3d& T_world_tip, VectorXd& q)>;

struct InverseTask {
  std::vector<Eigen::Isometry3d> poses;
  bool has_orientation = true;  ///< false: positions alone
  VectorXd start;               ///< (n); empty: the middle of the joints' ranges
};

/// Computes joints for given poses, each from the previous solution, by Newton steps on any arm or by a solver
/// of the caller, such as a closed form.
/// @throws InvalidInput  as forward_kinematics().
KinematicTable inverse_kinematics(const Model& arm, const std::string& frame,
                                  const InverseTask& task, const InverseSolver& solver = {});

/// `count` postures spread evenly over the joints' ranges (Halton's sequence). @throws InvalidInput  more than 12 joints.
KinematicTable sample_workspace(const Model& arm, const std::string& frame, int count);

/// Columns of the CSV: t, q1.., x, y, z, qw, qx, qy, qz, condition, smallest, manipulability, pose_condition; after inverse
/// kinematics status and errors; optionally the Jacobian's 6 n entries J1_1.. row by row.
enum class JacobianColumns { kWithout, kWith };
void write_kinematic_rows(const KinematicTable& table, const std::string& path,
                          JacobianColumns jacobian);

}  // namespace veridyn
