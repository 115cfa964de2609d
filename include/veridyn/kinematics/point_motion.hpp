#pragma once

#include <vector>

#include "veridyn/kinematics/tree.hpp"
#include "veridyn/math/types.hpp"

namespace veridyn {

/// Pose, twist, geometric Jacobian and its time derivative of one frame of an arm, or of a point fixed to
/// it, written in the world. Only the joints between it and the world are evaluated. Nothing allocates
/// after the constructor.
class PointMotion {
 public:
  /// @param arm  a tree of moving links (Tree::Keep::kMovingLinks). @param frame  index in the model.
  /// @param offset  of the point, in the frame.
  PointMotion(const Tree& arm, int frame, const Vec3d& offset = {0, 0, 0});

  /// @param q, dq  n entries each. Cost: O(joints above the frame).
  void update(const double* q, const double* dq) noexcept;

  int joints() const { return tree_.joints; }
  const Posed& pose() const { return T_; }         ///< T_world_frame, its origin at the point
  const Vec3d& velocity() const { return v_; }     ///< of the point
  const Vec3d& omega() const { return omega_; }
  /// (6 x n), linear rows first; and its time derivative.
  const MatrixXd& jacobian() const { return J_; }
  const MatrixXd& jacobian_rate() const { return dJ_; }

 private:
  /// A joint's axis z through p, and their rates.
  struct Axis {
    int link;
    Vec3d z, dz, p, dp;
  };

  Tree tree_;
  Posed T_link_point_;
  std::vector<Axis> axes_;  // from the world to the point
  Posed T_{identity_pose()};
  Vec3d v_{0, 0, 0}, omega_{0, 0, 0};
  MatrixXd J_, dJ_;
};

}  // namespace veridyn
