#pragma once

#include <vector>

#include "veridyn/kinematics/tree.hpp"
#include "veridyn/math/types.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// Pose, twist, geometric Jacobian and its time derivative of one frame of an arm, or of a point fixed to
/// it, written in the world. Only the joints between it and the world are evaluated. Nothing allocates
/// after the constructor.
class PointMotion {
 public:
  /// @param arm  a tree of moving links (Tree::Keep::kMovingLinks). @param
  ///   offset  position of the point in the frame [m].
  PointMotion(const Tree& arm, FrameIndex frame, const Vec3d& offset = {0, 0, 0});

  /// Computes pose, twist, Jacobian and its derivative. @param q, dq  n entries each. Cost: O(joints above the
  /// frame).
  void update(const double* q, const double* dq) noexcept;
  /// Computes pose and Jacobian; the rest stays as it is.
  void update(const double* q) noexcept;
  /// Computes the pose alone; the rest stays as it is.
  void place(const double* q) noexcept;

  int joints() const { return tree_.joints; }
  const Posed& pose() const { return T_; }         ///< T_world_frame, its origin at the point
  const Vec3d& velocity() const { return v_; }     ///< velocity of the point
  const Vec3d& omega() const { return omega_; }
  /// The geometric Jacobian (6 x n), linear rows first; and its time derivative.
  const MatrixXd& jacobian() const { return J_; }
  const MatrixXd& jacobian_rate() const { return dJ_; }

 private:
  /// A joint's axis z through p.
  struct Axis {
    Link link;
    Vec3d z, p;
  };

  /// Adds one axis' column (linear, angular), times each coefficient, to the columns of its coordinates.
  void add(const Axis& axis, const Vec3d& linear, const Vec3d& angular, MatrixXd& to) const;

  Tree tree_;
  Posed T_link_point_;
  std::vector<Axis> axes_;  // axes from the world to the point
  std::vector<double> angle_, sine_, cosine_;  // angles of the axes, in whole packs
  Posed T_{identity_pose()};
  Vec3d v_{0, 0, 0}, omega_{0, 0, 0};
  MatrixXd J_, dJ_;
};

}  // namespace veridyn
