#pragma once

#include <string>
#include <vector>

#include "veridyn/calibration/status.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

struct PoseDesignOptions {
  std::string frame;         ///< Tracked frame; empty: the last frame of the longest chain
  int poses = 30;            ///< number of poses to measure
  int candidates = 2000;     ///< random poses within the limits to choose from
  double limit_share = 1.0;  ///< share of each coordinate's range to use
  double rest = 1.0;         ///< [s] duration of the rest at each pose
  double position_noise = 1e-4;  ///< [m] standard deviation of the cameras' positions
  double angle_noise = 1e-3;     ///< [rad] standard deviation of their orientations
  unsigned seed = 1;
};

/// Poses that identify the constants of a robot file best: out of random poses within the limits,
/// those that maximise the determinant of the information about all identifiable constants
/// (D-optimal design by exchange), with base and tool pose unknown, ordered for short moves.
struct PoseDesign {
  CalibrationStatus status = CalibrationStatus::kCannotAnswer;
  std::string reason;
  std::string robot, frame;
  MatrixXd q;       ///< (poses x joints)
  VectorXd time;    ///< (poses) [s] at which each is reached, speeds within their limits
  /// Factor by which the mean standard deviation falls against as many random poses.
  double gain = 0.0;
  int constants = 0;  ///< identifiable constants, base and tool included
  struct Prediction {
    std::string name, unit;
    double deviation;  ///< standard deviation with the noise of the options
  };
  std::vector<Prediction> predictions;

  std::string report() const;
};

/// Status kCannotAnswer, with the reason, if no such poses exist.
/// @throws InvalidInput  the arm has no such frame.
PoseDesign design_poses(const Model& arm, const PoseDesignOptions& options = {});

}  // namespace veridyn
