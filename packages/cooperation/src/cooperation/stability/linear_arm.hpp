#pragma once

#include <vector>

#include "cooperation/scenario/scenario_models.hpp"
#include "veridyn/control/tip_kinematics.hpp"
#include "veridyn/cooperation/scenario.hpp"

namespace veridyn {

/// An arm and its controller about a point of rest, to first order:
///
///   M ddq + D dq + G q = tau + J' f,     tau = M_known y + G_known q + ...
///
/// q is relative to the point of rest. D is the friction that increases with speed; G is the change of
/// gravity, springs and the moment of the resting force with the position.
struct LinearArm {
  MatrixXd M, D, G;          ///< (n x n), of the arm
  MatrixXd J;                ///< (3 x n) of the tip, in the world
  MatrixXd M_known, G_known; ///< (n x n), as the controller knows them
  MatrixXd J_known;          ///< (3 x n), in the world
  MatrixXd J_base;           ///< (3 x n) the same in the base
  MatrixXd damped_inverse;   ///< (n x 3) of J_base by TaskInverse: accelerations of the joints for one of the tip
  MatrixXd null_space;       ///< (n x n) 1 - damped_inverse * J_base: projection of a posture's acceleration
  Eigen::Matrix3d R_world_base{Eigen::Matrix3d::Identity()};
  Eigen::Vector3d tip{Eigen::Vector3d::Zero()};  ///< [m] position in the world
  int joints() const { return static_cast<int>(M.rows()); }
};

/// @param q      (n) joints at rest.
/// @param force  on the tip at rest, in the world [N]. @param exerted  likewise, on the object as
///               the controller takes it into account; zero for a position loop.
LinearArm linear_arm(const ScenarioModels& models, const ScenarioArm& arm, const VectorXd& q,
                     const Eigen::Vector3d& force, const Eigen::Vector3d& exerted);

}  // namespace veridyn
