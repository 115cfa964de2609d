#pragma once

#include <Eigen/Geometry>
#include <string>
#include <utility>
#include <vector>

#include "veridyn/math/random_numbers.hpp"
#include "veridyn/calibration/axes.hpp"
#include "veridyn/calibration/capture.hpp"
#include "veridyn/model/model.hpp"

// Motion capture of a simulated arm: where every marker is follows from frame_pose() alone.

namespace veridyn {

struct CaptureNoise {
  double marker = 1e-4;    ///< [m] of one coordinate
  double outliers = 0.02;  ///< share of positions that are wrong by about `wrong`
  double dropouts = 0.05;  ///< share of positions that are hidden
  double wrong = 0.02;     ///< [m]
};

/// A pose at random: turns up to about 1.5 rad, shifts up to about `reach`.
Eigen::Isometry3d random_pose(RandomNumbers& random, double reach);

/// The pose with noise on position [m] and orientation [rad].
Eigen::Isometry3d with_noise(const Eigen::Isometry3d& T, double metres, double radians,
                        RandomNumbers& random);

/// The patient side manipulator's six marked bodies: base, yaw, upper, elbow, arm, and a sixth on
/// the arm's instrument, three markers each; q1 swept while q2 rests at zero, then q2 while q1 does.
MarkerCapture captured_psm(const Model& arm, int frames, const CaptureNoise& noise, unsigned seed);

/// A closed double parallelogram: base and a yawing body, on it two cranks ("near", "far"), which
/// carry a coupler at 0.15 m and another ("outer") at 0.23 m; three markers each, with noise alone.
///
/// @param play  [m] rms by which the joint of "far" and "outer" opens.
MarkerCapture captured_ladder(unsigned seed, int frames, double noise, double play = 0.0);
/// Its seven hinges; the last of either loop comes after the others, at 4 and 6.
std::vector<std::pair<std::string, std::string>> ladder_pairs();
/// Index of an axis among these pairs.
int ladder_pair(const CalibratedAxis& axis);
/// [m] between two of its axes.
double ladder_distance(const CalibratedAxis& first, const CalibratedAxis& second);

/// Poses of one frame at random configurations within `share` of the limits.
PoseCapture captured_poses(const Model& arm, const std::string& frame, int poses, double share,
                           double metres, double radians, unsigned seed,
                           const Eigen::Isometry3d& base = Eigen::Isometry3d::Identity(),
                           const Eigen::Isometry3d& tool = Eigen::Isometry3d::Identity());

/// A capture of poses that were made here.
PoseCapture capture_of(const std::vector<Eigen::Isometry3d>& poses);

}  // namespace veridyn
