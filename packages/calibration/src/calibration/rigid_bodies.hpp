#pragma once

#include <string>
#include <vector>

#include "closed_forms.hpp"
#include "veridyn/calibration/capture.hpp"

namespace veridyn::internal {

/// One body's markers as a rigid body.
struct RigidBody {
  std::string name;
  std::vector<int> markers;  ///< markers of the capture
  MatrixXd shape;            ///< (3 x markers) [m] about their mean, turned as at the first frame
  std::vector<char> seen;    ///< frames at which three or more markers agree with the shape
  Isometries pose;           ///< T_camera_body by frame; identity where not seen
  double noise = 0.0;        ///< [m] standard deviation of one coordinate of a marker
  double extent = 0.0;       ///< [m] largest distance of two markers
  double breadth = 0.0;      ///< [m] rms distance of the markers from the line that fits them best
  std::string fault;         ///< reason for a missing pose; empty: none
  int relabelled = 0;        ///< frames in which two markers had swapped names
  int outliers = 0;          ///< positions that do not fit the shape
};

/// Finds each body's shape from the distances of its markers, and its pose at every frame. Swapped
/// marker names are restored in `capture`; positions that do not fit become NaN.
std::vector<RigidBody> rigid_bodies(MarkerCapture& capture);

}  // namespace veridyn::internal
