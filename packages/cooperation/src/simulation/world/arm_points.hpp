#pragma once

#include <Eigen/Core>
#include <vector>

#include "veridyn/kinematics/recursion.hpp"
#include "veridyn/kinematics/tree.hpp"
#include "veridyn/math/types.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// Points of an arm with a given base pose: positions, velocities and Jacobians in the world.
/// Nothing allocates after the constructor.
class ArmPoints {
 public:
  ArmPoints(const Model& arm, const Posed& T_world_base);

  void move_to(const VectorXd& q, const VectorXd& dq) noexcept;

  struct Point {
    Eigen::Vector3d position, velocity;
  };
  Point point(int frame, const Eigen::Vector3d& offset) const noexcept;

  /// tau += J' f of the point, f in the world.
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
