#pragma once

#include <optional>

#include "veridyn/kinematics/recursion.hpp"
#include "veridyn/kinematics/tree.hpp"
#include "veridyn/math/types.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// Positions of points on frames, and their derivatives with respect to q. Owns its workspace: each thread
/// needs its own object.
class FramePoints {
 public:
  explicit FramePoints(const Model& arm);

  /// Computes the poses of all frames at q.
  void move_to(const VectorXd& q);

  /// A point of a frame in the world, and its derivative with respect to q; nullopt: a point of the world.
  Eigen::Vector3d point(std::optional<FrameIndex> frame, const Eigen::Vector3d& in_frame) const;
  MatrixXd point_slope(std::optional<FrameIndex> frame, const Eigen::Vector3d& in_frame) const;

  /// The frame's z axis in the world, and its derivative with respect to q.
  Eigen::Vector3d z_axis(std::optional<FrameIndex> frame) const;
  MatrixXd z_axis_slope(std::optional<FrameIndex> frame) const;

 private:
  Tree tree_;
  Recursion<double> recursion_;
  std::vector<Posed> T_world_;  // poses of all links
};

}  // namespace veridyn
