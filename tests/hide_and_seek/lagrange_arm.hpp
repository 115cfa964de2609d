#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "veridyn/model/model.hpp"

namespace veridyn::seek {

using Eigen::Matrix4d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// One DH row with its joint variable: the only data that are taken from the robot file.
struct Link {
  std::string name;
  int parent = -1;
  double a = 0.0, alpha = 0.0, d = 0.0, theta = 0.0;  ///< [m], [rad]
  bool modified = false;                              ///< Craig's order of the four
  bool slides = false;
  VectorXd ratios;  ///< (n) joint variable per coordinate; zero: fixed
  bool has_body = false;
  /// Moments of the body's mass over homogeneous points [x y z 1], in the link's frame: the
  /// integral of x x' dm with first moments and mass at its border. [kg m^2, kg m, kg]
  Matrix4d moments = Matrix4d::Zero();
};

/// Rigid bodies by Lagrange's equations over homogeneous transforms (Uicker 1965), with every
/// derivative taken numerically from positions alone:
///
///   tau_i = sum_b trace( dT_b/dq_i  J_b  (d2T_b/dt2 - [0 g])' )
///
/// It uses no angular velocities, inertia tensors or recursions, and so shares no code and no
/// formula with src/dynamics. Error of the fourth-order differences: about 1e-8 of the torque.
struct LagrangeArm {
  std::vector<Link> links;
  Vector3d gravity{0.0, 0.0, -9.81};
  int joints = 0;

  /// T_world_link of every link. @param q (n)
  std::vector<Matrix4d> poses(const VectorXd& q) const;

  /// (n) [N m], [N].
  VectorXd torque(const VectorXd& q, const VectorXd& dq, const VectorXd& ddq) const;

  /// (n x 10 bodies): torques per unit of every independent entry of the moments.
  MatrixXd regressor(const VectorXd& q, const VectorXd& dq, const VectorXd& ddq) const;

  /// torque() for every row of (rows x n) matrices.
  MatrixXd torques(const MatrixXd& q, const MatrixXd& dq, const MatrixXd& ddq) const;

 private:
  // Calls visit(joint, link, W) with W = D' (d2T/dt2 - [0 g]); the torque is the sum of J .* W.
  using Visit = std::function<void(int, int, const Matrix4d&)>;
  void for_each_force(const VectorXd& q, const VectorXd& dq, const VectorXd& ddq,
                      const Visit& visit) const;
};

/// The rows of a robot file whose frames are all DH rows; bodies without values.
LagrangeArm lagrange_arm(const Model& arm);

/// Moments of a point mass.
Matrix4d point_mass(double mass, const Vector3d& place);

}  // namespace veridyn::seek
