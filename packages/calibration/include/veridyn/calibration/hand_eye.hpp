#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "veridyn/calibration/capture.hpp"
#include "veridyn/calibration/status.hpp"

namespace veridyn {

/// Relation between two recordings of poses A_k and B_k.
enum class HandEyeForm {
  kCommonPoses,   ///< A_k = T B_k: both record the same frames; T is the pose of B's base in A's
  kCommonPoints,  ///< positions only: a_k = T b_k, as of tips that touch
  kHandEye,       ///< A_k T = T B_k: relative motions of a hand and of the sensor that it carries
  kEyeInHand,     ///< A_k T B_k = world: arm and camera on its hand that sees a still target
  kTwoBases,      ///< A_k tool = T B_k: hands that hold one object; T: B's base in A's
};

/// "common-poses", "common-points", "hand-eye", "eye-in-hand", "two-bases".
const char* name_of(HandEyeForm form);

struct HandEyeOptions {
  std::optional<HandEyeForm> form;  ///< nullopt: the form with the fewest unknowns that fits
  double smallest_swing = 1.0;      ///< [deg] smallest rms turn about a second axis
};

/// Pose between two arms, or between an arm and a camera, by nonlinear least squares with Huber's
/// loss on positions and orientations, each weighted by its own noise. Closed forms give the
/// initial values: Kabsch, and Shah for A X = Y B. Half widths are 95 %.
struct HandEye {
  CalibrationStatus status = CalibrationStatus::kCannotAnswer;
  std::string reason;
  HandEyeForm form = HandEyeForm::kTwoBases;
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();  ///< T
  double radius = 0.0;        ///< [m] 95 % bound on the error of its translation
  double radius_angle = 0.0;  ///< [rad] 95 % bound on the error of its rotation
  /// With kTwoBases the tool, T_handA_handB; with kEyeInHand the target's pose in A's base; else nullopt.
  std::optional<Eigen::Isometry3d> other;
  double other_radius = 0.0, other_radius_angle = 0.0;
  int pairs = 0, outliers = 0;
  double rms = 0.0;        ///< [m] rms residual of positions, without outliers
  double rms_angle = 0.0;  ///< [rad] rms residual of orientations; 0 if only positions are used
  std::vector<Eigen::Vector3d> residuals;  ///< [m] residuals of positions, one per pair
  std::vector<double> residual_angles;     ///< [rad] residuals of orientations, one per pair
  Eigen::Vector3d swing{0, 0, 0};          ///< [deg] rms turns of A along the axes of their spread
  struct Alternative {
    HandEyeForm form;
    double rms, rms_angle;
    std::string reason;  ///< reason if it is not identifiable; empty: it was fitted
  };
  std::vector<Alternative> forms;  ///< all forms that were tried

  std::string report() const;
};

/// @param A, B  recordings whose rows correspond one to one.
/// @throws InvalidInput  the files do not have the same number of rows.
HandEye calibrate_hand_eye(const PoseCapture& A, const PoseCapture& B,
                           const HandEyeOptions& options = {});

}  // namespace veridyn
