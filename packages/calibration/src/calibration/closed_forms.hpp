#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "veridyn/math/types.hpp"

// Closed forms for poses, axes and centres: initial values of the nonlinear fits, and references
// for tests.

namespace veridyn::internal {

using Isometries = std::vector<Eigen::Isometry3d>;

/// The vector w with R = exp([w]x), |w| <= pi.
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R);

/// Rotation exp([w]x) by a rotation vector [rad], by the formula of Rodrigues.
Eigen::Matrix3d rotation_of(const Eigen::Vector3d& w);

/// The inverse of the left Jacobian of SO(3): log(exp(d) exp(w)) = w + J d for small d.
Eigen::Matrix3d left_jacobian_inverse(const Eigen::Vector3d& w);

/// The right Jacobian of SO(3): exp(w + d) = exp(w) exp(J d) for small d.
Eigen::Matrix3d right_jacobian(const Eigen::Vector3d& w);

/// [v]x, the matrix of the vector product.
Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v);

/// The rotation nearest to a matrix in the least-squares sense.
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& M);

/// T with sum || T a_k - b_k ||^2 least. Source: Kabsch, Acta Crystallographica A32, 1976.
/// @param a, b  (3 x points), at least three points not on a line.
Eigen::Isometry3d fitted_pose(const MatrixRef& a, const MatrixRef& b);

/// Spread of orientations: eigenvalues and eigenvectors of mean (R - mean R)' (R - mean R),
/// smallest first. The smallest is zero if all rotate about one axis, which is its eigenvector (in
/// the body); each is the mean square displacement of a unit vector.
struct RotationSpread {
  Eigen::Vector3d eigenvalues;
  Eigen::Matrix3d axes;
  Eigen::Matrix3d mean;  ///< mean of the rotation matrices, not itself a rotation
};
RotationSpread rotation_spread(const Isometries& poses);

/// A line in space; the direction has length one.
struct Line {
  Eigen::Vector3d direction{0, 0, 1};
  Eigen::Vector3d point{0, 0, 0};
};

/// The common axis of two bodies from T_a_b, written in a and in b. Residuals omit the largest
/// twentieth.
struct CommonAxis {
  Line in_a, in_b;
  double wobble = 0.0;  ///< [rad] rms angle between the two lines
  double play = 0.0;    ///< [m] rms distance of the two points across the axis
  double slide = 0.0;   ///< [m] rms displacement along it
};
CommonAxis common_axis(const Isometries& T_a_b);

/// X and Y with A_k X = Y B_k. Source: Shah, Journal of Mechanisms and Robotics 5(3), 2013 for the
/// rotations; translations by linear least squares.
struct HandAndWorld {
  Eigen::Isometry3d X, Y;
};
HandAndWorld hand_and_world(const Isometries& A, const Isometries& B);

/// X with A_k X = X B_k. Source: Park and Martin, IEEE Transactions on Robotics and Automation
/// 10(5), 1994.
Eigen::Isometry3d solve_hand_eye(const Isometries& A, const Isometries& B);

}  // namespace veridyn::internal
