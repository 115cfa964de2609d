#pragma once

#include <optional>
#include <string>
#include <vector>

#include "veridyn/math/types.hpp"
#include "veridyn/files/link_shapes.hpp"

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

/// A box that stands in the world [m]: a table, a mount, a wall; infinite where a side is open, so
/// that a floor is a box without an end below.
struct Obstacle {
  std::string name;
  Eigen::Vector3d lower{0, 0, 0};
  Eigen::Vector3d upper{0, 0, 0};
};

/// A link keeps `clearance` [m] from another, or from an obstacle.
struct CollisionPair {
  std::string first, second;
  std::vector<Capsule> capsules;      ///< of the first
  std::vector<Capsule> others;        ///< of the second; empty: it is the obstacle
  std::optional<Obstacle> obstacle{};
  double clearance = 0.0;
};

/// Distance between links that is kept unless another is given: some encoder and mounting errors, and
/// what a controller overshoots.
constexpr double kLinkClearance = 0.01;

struct CollisionLimits {
  std::vector<CollisionPair> pairs;
  /// "A and B": links that touch at nearly every posture, since their shapes overlap where they are
  /// joined, and links that stand on an obstacle whatever the joints do; they are not kept apart.
  std::vector<std::string> touching;
  /// "A and B": a link that reaches into an obstacle at every posture. It stays among the pairs, so that
  /// no motion keeps these limits.
  std::vector<std::string> impossible{};
  std::vector<Capsule> shapes{};       ///< of the links, as given
  std::vector<Obstacle> obstacles{};   ///< as given
};

/// The pairs of links that are to be kept apart: links that one joint connects are not, nor are
/// frames that do not move against each other. Every link that moves is kept clear of every obstacle.
/// @param shapes  capsules on frames of the arm, or in the world.
/// @throws InvalidInput  a capsule on an unknown frame, or an obstacle without size.
CollisionLimits collision_limits(const Model& arm, const std::vector<Capsule>& shapes,
                                 const std::vector<Obstacle>& obstacles = {},
                                 double clearance = kLinkClearance);

/// Limits of a motion beside the ranges and speeds of its joints.
struct WorkspaceLimits {
  std::vector<FrameBox> boxes;
  std::vector<SpherePair> pairs;
  std::vector<InsertionRange> insertions;
  CollisionLimits collisions{};
};

}  // namespace veridyn
