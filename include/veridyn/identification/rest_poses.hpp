#pragma once

#include <optional>
#include <string>
#include <vector>

#include "veridyn/identification/identification.hpp"

namespace veridyn {

/// Poses at which an arm stood still while a controller held it, and the torques of that.
struct RestPoses {
  std::string source;
  MatrixXd q;         ///< (poses x n) [rad], [m]
  MatrixXd tau;       ///< (poses x n) [N m], [N]
  MatrixXd approach;  ///< (poses x n) sign of the motion before the pose; 0: unknown

  Eigen::Index poses() const { return q.rows(); }
};

/// The poses of a recording. Where its velocities are those of a motion, moments at which no joint
/// moves are one pose each, the mean over them, approached as the joints moved last. Where there are
/// none, or all are zero, every row is a pose. Where all are -1, 0 or 1 they say from which side each
/// joint came. A file needs no time.
///
/// @param approach  of all joints and poses, in place of what the recording says.
/// @throws InvalidInput  the file is bad, does not fit the arm, or has no pose.
RestPoses read_rest_poses(const Model& arm, const std::string& path,
                          const PreprocessingOptions& how, std::optional<double> approach = {});

/// True if a recording is of poses: it has velocities, they are never anything but zero, and the
/// positions are no motion whose velocities were not recorded.
bool is_at_rest(const Model& arm, const std::string& path, const PreprocessingOptions& how);

/// The arm without effects that need motion; dry friction stays where poses are `approached` from known sides.
Model with_effects_at_rest(const Model& arm, bool approached);

/// [N m], [N] level of constant dry friction that the values of an arm give each coordinate, (n).
VectorXd dry_friction(const Model& arm);

/// A factor for every joint and part of the poses.
CompressedRecording compress(const Model& arm, const RestPoses& poses);

/// identify() from poses alone, where velocities and accelerations are zero:
///
///   tau = g(q) + offsets + forces of position + level * approach
///
/// The base parameters are those that the training poses determine; joints that stand still, and
/// whatever else they leave open, determine fewer. What moves only (inertia, viscous friction) is not
/// in the model, and bodies have the inertia of a prior: that of the options, of the robot file, or a
/// ball. Dry friction is identified where the approach of poses is known; elsewhere the remarks say how
/// far it spreads the torques of each joint.
///
/// Preprocessing is not used: nothing is filtered, dropped or differentiated.
/// @throws InvalidInput  the poses do not fit the arm.
Identification identify_at_rest(const Model& arm, const std::vector<RestPoses>& train,
                                const std::vector<RestPoses>& test = {},
                                const IdentificationOptions& options = {});

}  // namespace veridyn
