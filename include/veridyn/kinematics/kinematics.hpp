// kinematics/: poses, Jacobians and velocities of frames.
#pragma once

#include <Eigen/Geometry>

#include "veridyn/model/model.hpp"

namespace veridyn {

/// T_world_frame of one frame.
///
/// @param q  (n) [rad], metres where the joint is prismatic.
/// @throws InvalidInput  q does not have arm.joints() entries, or there is no such frame.
Eigen::Isometry3d frame_pose(const Model& arm, const VectorRef& q, FrameIndex frame);

/// Velocity of the frame's origin and angular velocity of the frame, both written in the world:
///
///   [v; omega] = J(q) * dq
///
/// The geometric Jacobian; (6 x n), linear rows first (thesis 4.1).
MatrixXd frame_jacobian(const Model& arm, const VectorRef& q, FrameIndex frame);

/// dJ/dt along dq; (6 x n), so that [a; alpha] = J ddq + (dJ/dt) dq.
MatrixXd frame_jacobian_rate(const Model& arm, const VectorRef& q, const VectorRef& dq, FrameIndex frame);

}  // namespace veridyn
