#pragma once

#include <string>
#include <vector>

#include "veridyn/calibration/status.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

struct PoseDesignOptions {
  std::string frame;         ///< Tracked frame; empty: the last frame of the longest chain
  int poses = 30;            ///< to drive to
  int candidates = 2000;     ///< among random poses within the limits
  double limit_share = 1.0;  ///< share of each coordinate's range to use
  double rest = 1.0;         ///< [s] at each pose
  double position_noise = 1e-4;  ///< [m] of the cameras
  double angle_noise = 1e-3;     ///< [rad]
  unsigned seed = 1;
};

/// Poses that tell the constants of a robot file apart best: among random poses within the limits,
/// those that make the determinant of the information about all identifiable constants largest
/// (D-optimal, by exchange), base and tool pose unknown, in an order with short ways.
struct PoseDesign {
  CalibrationStatus status = CalibrationStatus::kCannotAnswer;
  std::string reason;
  std::string robot, frame;
  MatrixXd q;       ///< (poses x joints)
  VectorXd time;    ///< (poses) [s] at which each is reached, speeds within their limits
  double gain = 0.0;  ///< by how much the mean deviation falls against as many random poses, factor
  int constants = 0;  ///< identifiable, base and tool included
  struct Prediction {
    std::string name, unit;
    double deviation;  ///< standard deviation with the noise of the options
  };
  std::vector<Prediction> predictions;

  std::string report() const;
};

/// @throws InvalidInput  the arm has no such frame.
PoseDesign design_poses(const Model& arm, const PoseDesignOptions& options = {});

}  // namespace veridyn
