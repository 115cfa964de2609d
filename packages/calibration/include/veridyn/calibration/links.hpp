#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "veridyn/calibration/capture.hpp"
#include "veridyn/calibration/status.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// Assumption about the pose of the robot's base in the frame of the cameras, or of the tracked body in its
/// frame of the robot.
enum class AttachedPose {
  kAutomatic,  ///< known if the robot file's poses are close and fit equally well, else free
  kKnown,      ///< the two coincide
  kFree,       ///< six unknowns, or three where only positions are recorded
};

struct LinksOptions {
  std::string frame;  ///< Tracked frame; empty: the last frame of the longest chain
  AttachedPose base = AttachedPose::kAutomatic;
  AttachedPose tool = AttachedPose::kAutomatic;
  int most_named = 6;     ///< largest number of wrong constants to report; more count as many small errors
  double outlier = 5.0;   ///< standard deviations beyond which a pose is an outlier
  int threads = 1;
};

/// One constant of a robot file with its estimate from the poses.
struct LinkConstant {
  std::string name;   ///< "beta", "a", "theta", "ratio of insertion", "zero of pitch", "base x", ...
  std::string frame;  ///< frame to which the constant belongs; empty: none
  std::string unit;   ///< "m", "rad" or "1"
  double file = 0.0;
  double found = 0.0;
  double low = 0.0, high = 0.0;  ///< 95 % interval of the estimate if this constant is free
  bool identifiable = false;
  bool changed = false;  ///< `found` differs from `file`
  /// Reason why it is not identifiable, or the constants that it is confounded with.
  std::string why;
};

/// Calibrates constants of a robot file from poses or positions of one frame and joint readings.
///
/// Identifiable constants are found as for inertial parameters, by a rank-revealing choice of
/// independent columns. Then the smallest set is sought that explains the poses as well as all
/// constants do; if there is one, only its constants change, and they are named. Otherwise all
/// identifiable constants change a little. Nonlinear least squares with Huber's loss, and without
/// outliers at the end.
struct LinksCalibration {
  CalibrationStatus status = CalibrationStatus::kCannotAnswer;
  std::string reason;
  std::string robot, source, frame;
  int frames = 0, outliers = 0;
  bool base_free = false, tool_free = false;
  Eigen::Isometry3d base = Eigen::Isometry3d::Identity();  ///< T_camera_base
  Eigen::Isometry3d tool = Eigen::Isometry3d::Identity();  ///< T_frame_body
  std::vector<LinkConstant> constants;
  /// Constants that differ from the file, most significant first; empty if all changed a little.
  std::vector<int> named;
  bool explained = false;  ///< the reported ones (or none) explain the poses as well as all constants do
  double rms_file = 0.0;      ///< [m] rms error of positions with the file's constants
  double rms = 0.0;           ///< [m] rms error of positions with the constants found
  double rms_angle = 0.0;     ///< [rad] rms error of orientations
  double held_out_rms = 0.0;  ///< [m] rms error on the quarter of the poses that was not fitted, without outliers
  double held_out_rms_all = 0.0;  ///< [m] likewise, outliers included
  double held_out_rms_file = 0.0; ///< [m] likewise, with the file's constants
  double held_out_angle = 0.0;    ///< [rad] rms error of orientations on that quarter
  double rank_gap = 0.0;
  double correlation = 1.0;   ///< number of successive frames that count as one independent frame
  std::optional<Model> model;  ///< the robot with the constants found
  std::vector<Eigen::Vector3d> positions;  ///< [m] measured, in the frame of the cameras, for drawings
  MatrixXd joints;  ///< (frames x joints) [rad], [m] as recorded, for drawings
  std::vector<double> residuals, residual_angles;  ///< [m], [rad] residuals, one per frame
  double seconds = 0.0;

  std::string report() const;
};

/// Status kCannotAnswer, with the reason, if the poses do not suffice or contradict the frame.
/// @throws InvalidInput  the recording has other joints than the arm, or the arm no such frame.
LinksCalibration calibrate_links(const Model& arm, const PoseCapture& poses,
                                 const LinksOptions& options = {});

/// One line that compares a wrong constant found from torques with the estimate from the poses: they agree,
/// the poses show another constant, or they show no error.
/// @param frame, name, found, low, high  of the constant as `diagnose` reports it ("theta", "ratio of pitch"), in
/// the unit of its LinkConstant, with its interval.
std::string compare_wrong_constant(const LinksCalibration& links, const std::string& frame,
                                   const std::string& name, double found, double low, double high);

}  // namespace veridyn
