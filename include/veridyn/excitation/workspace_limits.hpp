#pragma once

#include <string>
#include <vector>

#include "veridyn/math/types.hpp"

namespace veridyn {

/// The origin of a frame stays within a box of the world [m]; infinite where a side is open.
struct FrameBox {
  std::string frame;
  Eigen::Vector3d lower{0, 0, 0};
  Eigen::Vector3d upper{0, 0, 0};
};

/// A sphere attached to a frame, or fixed in the world if `frame` is "world".
struct Sphere {
  std::string frame;
  double radius = 0.0;              ///< [m]
  Eigen::Vector3d centre{0, 0, 0};  ///< in the frame [m]
};

/// Two spheres do not touch: the distance of their centres is at least the sum of the radii plus
/// `clearance` [m].
struct SpherePair {
  Sphere first;
  Sphere second;
  double clearance = 0.0;
};

/// Range of insertion of a tool through a remote centre of motion: the displacement from the centre
/// to the frame's origin along the frame's z axis [m].
struct InsertionRange {
  std::string frame;
  Eigen::Vector3d centre{0, 0, 0};  ///< in the world [m]
  double lower = 0.0;
  double upper = 0.0;
};

/// Limits of a motion beside the ranges and speeds of its joints.
struct WorkspaceLimits {
  std::vector<FrameBox> boxes;
  std::vector<SpherePair> pairs;
  std::vector<InsertionRange> insertions;

  bool empty() const { return boxes.empty() && pairs.empty() && insertions.empty(); }
};

}  // namespace veridyn
