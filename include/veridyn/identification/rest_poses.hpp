#pragma once

#include <optional>
#include <string>
#include <vector>

#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// Poses at which a controller holds an arm at rest, with the torques.
struct RestPoses {
  std::string source;
  MatrixXd q;         ///< (poses x n) [rad], [m]
  MatrixXd tau;       ///< (poses x n) [N m], [N]
  MatrixXd approach;  ///< (poses x n) sign of the motion before the pose; 0: unknown

  Eigen::Index poses() const { return q.rows(); }
};

/// The poses of a recording. If it contains velocities of a motion, each interval without motion is one pose, the
/// mean over its rows, approached in the direction of the last motion. If there are no velocities, or all are zero,
/// every row is a pose. Velocities that are all -1, 0 or 1 are directions of approach. A file needs no time.
///
/// @param approach  direction for all joints and poses, which replaces that of the recording.
/// @throws InvalidInput  the file is bad, does not fit the arm, or has no pose.
RestPoses read_rest_poses(const Model& arm, const std::string& path,
                          const PreprocessingOptions& how, std::optional<double> approach = {});

/// True if a recording consists of poses: it has velocities, all are zero, and the positions do not
/// change like those of a motion.
bool is_at_rest(const Model& arm, const std::string& path, const PreprocessingOptions& how);

/// The arm without effects that act in motion only; dry friction is kept if the poses are `approached` from known sides.
Model with_effects_at_rest(const Model& arm, bool approached);

/// Level of the constant dry friction of each coordinate (n), by the values of the arm [N m], [N].
VectorXd dry_friction(const Model& arm);

/// Compresses poses to a factor for every joint and part of the poses.
CompressedRecording compress(const Model& arm, const RestPoses& poses);

/// identify() from poses alone, where velocities and accelerations are zero:
///
///   tau = g(q) + offsets + forces of position + level * approach
///
/// The base parameters are those that the training poses determine. Effects that act in motion only
/// (inertia, viscous friction) are not in the model, and bodies have the inertia of a prior: that of
/// the options, of the robot file, or of a ball. Dry friction is identified if the direction of
/// approach is known; else the remarks state the scatter that it causes in the torque of each joint.
///
/// Preprocessing is not used: nothing is filtered, dropped or differentiated.
/// @throws InvalidInput  the poses do not fit the arm.
Identification identify_at_rest(const Model& arm, const std::vector<RestPoses>& train,
                                const std::vector<RestPoses>& test = {},
                                const IdentificationOptions& options = {});

}  // namespace veridyn
