#pragma once

#include <optional>
#include <vector>

#include "excitation/limits/frame_points.hpp"
#include "veridyn/excitation/workspace_limits.hpp"

namespace veridyn {

/// The smallest distance between the surfaces of two links, or of a link and an obstacle; negative
/// where they overlap.
class LinkGap {
 public:
  /// @throws InvalidInput  a capsule on an unknown frame.
  LinkGap(const Model& arm, const CollisionPair& pair);

  /// The closest points of the two, on the axes of their capsules.
  struct Nearest {
    double gap = 0.0;
    Eigen::Vector3d direction{0, 0, 0};  ///< unit vector from the second to the first, in the world
    std::optional<FrameIndex> frame;     ///< frame of `point`; nullopt: the world
    Eigen::Vector3d point{0, 0, 0};      ///< closest point in this frame [m]
    std::optional<FrameIndex> other;
    Eigen::Vector3d other_point{0, 0, 0};
  };
  Nearest nearest(const FramePoints& at) const;

 private:
  struct Rod {
    std::optional<FrameIndex> frame;
    Eigen::Vector3d from, to;
    double radius;
  };
  static Rod rod_of(const Model& arm, const Capsule& capsule);

  std::vector<Rod> first_, second_;
  std::optional<Obstacle> obstacle_;
};

}  // namespace veridyn
