#pragma once

#include <optional>
#include <string>
#include <vector>

#include "veridyn/math/types.hpp"
#include "veridyn/files/link_shapes.hpp"

namespace veridyn {

/// Quantities with limits; kPlace: of frames and links, in space.
enum class LimitKind { kPosition, kSpeed, kAcceleration, kStop, kTorque, kPlace };

/// The origin of a frame stays within a box of the world [m]; infinite where the box is open.
struct FrameBox {
  std::string frame;
  Eigen::Vector3d lower{0, 0, 0};
  Eigen::Vector3d upper{0, 0, 0};
};

/// A sphere attached to a frame, or fixed in the world if `frame` is "world".
struct Sphere {
  std::string frame;
  double radius = 0.0;              ///< [m]
  Eigen::Vector3d centre{0, 0, 0};  ///< centre in the frame [m]
};

/// Two spheres do not touch: the distance of their centres is at least the sum of the radii plus `clearance` [m].
struct SpherePair {
  Sphere first;
  Sphere second;
  double clearance = 0.0;
};

/// Range of insertion of a tool through a remote centre of motion: the displacement from the centre
/// to the frame's origin along the frame's z axis [m].
struct InsertionRange {
  std::string frame;
  Eigen::Vector3d centre{0, 0, 0};  ///< remote centre in the world [m]
  double lower = 0.0;
  double upper = 0.0;
};

/// A box fixed in the world [m]: a table, a mount, a wall; infinite where it is open, so that a floor is a
/// box without a lower end.
struct Obstacle {
  std::string name;
  Eigen::Vector3d lower{0, 0, 0};
  Eigen::Vector3d upper{0, 0, 0};
};

/// Two links, or a link and an obstacle, keep `clearance` [m] from each other.
struct CollisionPair {
  std::string first, second;
  std::vector<Capsule> capsules;      ///< capsules of the first link
  std::vector<Capsule> others;        ///< capsules of the second link; empty: the second is the obstacle
  std::optional<Obstacle> obstacle{};
  double clearance = 0.0;
};

/// Default clearance between links: it covers some encoder and mounting errors, and the overshoot of a controller.
constexpr double kLinkClearance = 0.01;

struct CollisionLimits {
  std::vector<CollisionPair> pairs;
  /// "A and B": links that touch in nearly every posture, since their shapes overlap at the joint, and links
  /// that stand on an obstacle in every posture; they are not kept apart.
  std::vector<std::string> touching;
  /// "A and B": a link that reaches into an obstacle in every posture. It remains among the pairs, so that no
  /// motion satisfies these limits.
  std::vector<std::string> impossible{};
  std::vector<Capsule> shapes{};       ///< all capsules that were given
  std::vector<Obstacle> obstacles{};   ///< all obstacles that were given
};

/// The pairs of links to keep apart, except links that one joint connects, and frames that do not move
/// relative to each other. Every moving link is kept apart from every obstacle.
/// @param shapes  capsules on frames of the arm, or in the world.
/// @throws InvalidInput  a capsule on an unknown frame, or an obstacle without size.
CollisionLimits collision_limits(const Model& arm, const std::vector<Capsule>& shapes,
                                 const std::vector<Obstacle>& obstacles = {},
                                 double clearance = kLinkClearance);

/// Limits of a motion in addition to the ranges and speeds of its joints.
struct WorkspaceLimits {
  std::vector<FrameBox> boxes;
  std::vector<SpherePair> pairs;
  std::vector<InsertionRange> insertions;
  CollisionLimits collisions{};
};

}  // namespace veridyn
