#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "veridyn/calibration/capture.hpp"
#include "veridyn/calibration/status.hpp"

namespace veridyn {

struct RemoteCenterOptions {
  int fewest_frames = 10;      ///< fewer frames are refused
  double smallest_swing = 1.0; ///< [deg] rms turn about the second axis; less is refused
  double outlier = 4.0;        ///< standard deviations beyond which a frame is an outlier
};

/// The remote centre of motion: the fixed point about which a body turns, seen from the body and
/// from the cameras:
///
///   rcm = R_k * tip + p_k   for every frame k                        (thesis A.9, A.10)
///
/// Least squares; each frame is weighted by the noise of its position and of its orientation at the
/// length of `tip`. Half widths are those of 95 % intervals, with correlated frames counted once.
struct RemoteCenter {
  CalibrationStatus status = CalibrationStatus::kCannotAnswer;
  std::string reason;  ///< reason if it is not identifiable; empty if it is
  std::string source, body;
  int frames = 0, outliers = 0;
  Eigen::Vector3d rcm{0, 0, 0};  ///< [m] position in the frame of the cameras (b_post)
  Eigen::Vector3d tip{0, 0, 0};  ///< [m] position in the frame of the body (b_tip)
  /// [m] scatter of rcm computed from single frames, per axis (thesis Table 6.1)
  Eigen::Vector3d rms{0, 0, 0};
  Eigen::Vector3d rms_all{0, 0, 0};  ///< [m] likewise, outliers included
  Eigen::Vector3d rcm_half_width{0, 0, 0}, tip_half_width{0, 0, 0}, rms_half_width{0, 0, 0};
  double rcm_radius = 0.0;         ///< [m] 95 % bound on the error of rcm
  double condition = 0.0;  ///< condition number of (A.10): largest over smallest singular value
  /// [deg] rms rotation about the principal axes of the motion, smallest first
  Eigen::Vector3d swing{0, 0, 0};
  double position_noise = 0.0;     ///< [m] standard deviation of one coordinate, estimated from the frames
  double orientation_noise = 0.0;  ///< [rad] likewise, about one axis
  double correlation = 1.0;        ///< number of successive frames that count as one independent frame
  std::vector<Eigen::Vector3d> points;   ///< rcm computed from each single frame
  std::vector<char> is_outlier;          ///< one flag per frame
  std::vector<Eigen::Isometry3d> poses;  ///< poses to which it was fitted

  std::string report() const;
};

/// @throws InvalidInput  the recording has no orientations.
RemoteCenter calibrate_remote_center(const PoseCapture& poses,
                                     const RemoteCenterOptions& options = {});

}  // namespace veridyn
