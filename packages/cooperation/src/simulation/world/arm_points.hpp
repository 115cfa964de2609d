#pragma once

#include <Eigen/Core>
#include <vector>

#include "veridyn/kinematics/recursion.hpp"
#include "veridyn/kinematics/tree.hpp"
#include "veridyn/math/types.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// Points of an arm with a given base pose: positions, velocities and Jacobians in the world. A point is an
/// `offset` [m] in the axes of `frame`, an index in Model::frames().
/// Nothing allocates after the constructor.
class ArmPoints {
 public:
  ArmPoints(const Model& arm, const Posed& T_world_base);

  void move_to(const VectorXd& q, const VectorXd& dq) noexcept;

  struct Point {
    Eigen::Vector3d position, velocity;  ///< [m], [m/s] in the world
  };
  Point point(int frame, const Eigen::Vector3d& offset) const noexcept;

  /// tau += share * J' f of the point, f in the world [N].
  void add_force(int frame, const Eigen::Vector3d& offset, const Eigen::Vector3d& force,
                 double share, VectorXd& tau) const noexcept;

  /// Jacobian (3 x n) of the velocity of the point in the world.
  void jacobian(int frame, const Eigen::Vector3d& offset, MatrixXd& J) const noexcept;

 private:
  Tree tree_;
  Recursion<double> recursion_;
  Posed base_;
  VectorXd dq_;
  std::vector<Posed> T_world_;  // pose of every link in the world
};

}  // namespace veridyn
