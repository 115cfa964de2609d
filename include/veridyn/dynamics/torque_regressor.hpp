#pragma once

#include <vector>

#include "veridyn/dynamics/aligned_workspace.hpp"
#include "veridyn/dynamics/link_inertia.hpp"
#include "veridyn/kinematics/tree.hpp"
#include "veridyn/math/types.hpp"
#include "veridyn/model/model.hpp"

namespace veridyn {

/// torque_regressor() of one arm for repeated calls, at one state or at many samples at once, several
/// per instruction. The widest vectors that the processor has are chosen at run time; results agree
/// between machines to rounding only.
///
/// Constant functions serve several threads; each call allocates a workspace of a few kilobytes. Pass
/// rows in blocks of some hundred, so that the results stay in the cache.
class TorqueRegressor {
 public:
  explicit TorqueRegressor(const Model& arm);

  int joints() const { return tree_.joints; }

  /// Columns of the regressor that can differ from zero for a joint: ten for each body that it
  /// moves, ascending, in 0 .. 10 * bodies - 1. See torque_regressor().
  const std::vector<int>& columns(JointIndex joint) const { return columns_[joint.value]; }

  /// The regressor at one state; nothing allocates. @param Y  (n x 10 bodies), of the right size.
  void evaluate(const VectorRef& q, const VectorRef& dq, const VectorRef& ddq, MatrixXd& Y);

  /// Y[i](r, c): torque of joint i in sample r per unit of inertial parameter columns(i)[c].
  ///
  /// @param q, dq, ddq  (rows x n) [rad, rad/s, rad/s^2], metres where the joint is prismatic.
  /// @param Y           one matrix per joint, (rows x columns(i).size()); sized here. If a matrix has as many
  ///   rows and more columns, its further columns are unchanged.
  /// @throws InvalidInput  the three do not have n columns and one number of rows.
  void evaluate(const MatrixRef& q, const MatrixRef& dq, const MatrixRef& ddq,
                std::vector<MatrixXd>& Y) const;

  /// Computes Y[first] .. Y[end - 1] only; the other matrices are unchanged.
  void evaluate(const MatrixRef& q, const MatrixRef& dq, const MatrixRef& ddq, int first, int end,
                std::vector<MatrixXd>& Y) const;

  /// Inverse dynamics of all samples.
  ///
  /// @param phi  (10 * bodies) of all bodies, ten of each in the order of InertialParameters;
  ///             `*arm.inertial_values()` where the file or identified model has them.
  /// @param tau  (rows x n) [N m, N]; sized here.
  /// @throws InvalidInput  as above, or phi has the wrong size.
  void torques(const MatrixRef& q, const MatrixRef& dq, const MatrixRef& ddq, const VectorRef& phi,
               MatrixXd& tau) const;

  /// The derivatives of f = sum_i <weights[i], Y[i]> by every entry of q, dq and ddq: the chain
  /// rule from a criterion of the regressor back to the motion.
  ///
  /// @param weights  one matrix per joint, of the size of Y[i].
  /// @param slopes   (rows x 3 n): derivatives by the row's q (n columns), by its dq, by its ddq;
  /// sized here.
  /// @throws InvalidInput  as above, or weights of another size. Cost: about 8 n regressors.
  void gradient(const MatrixRef& q, const MatrixRef& dq, const MatrixRef& ddq,
                const std::vector<MatrixXd>& weights, MatrixXd& slopes) const;

  /// The derivatives of the torques: column d n + i holds dtau_i / dx_d, x = (q, dq, ddq).
  ///
  /// @param slopes  (rows x 3 n^2); sized here.
  void torque_derivatives(const MatrixRef& q, const MatrixRef& dq, const MatrixRef& ddq,
                          const VectorRef& phi, MatrixXd& slopes) const;

 private:
  std::vector<LinkInertia> inertias(const VectorRef& phi) const;

  Tree tree_;
  internal::AlignedWorkspace memory_;
  std::vector<std::vector<int>> columns_;
  /// Index of body b's first column in joint i's matrix, at b n + i; -1: the joint does not move the body.
  std::vector<int> first_column_;
};

/// Joint torques as a linear map of the bodies' inertial parameters:
///
///   tau = Y(q, dq, ddq) * phi
///
/// Columns 10b .. 10b+9 belong to body b, in the order of InertialParameters.
/// Source: Atkeson, An and Hollerbach, IJRR 5(3), 1986. Cost: O(bodies * n).
///
/// @param q, dq, ddq  (n) [rad, rad/s, rad/s^2]; metres where the joint is prismatic.
/// @returns Y (n x 10 bodies); row i is coordinate i, in [N m] ([N] if prismatic) per unit of phi.
/// @throws InvalidInput  a vector does not have arm.joints() entries.
MatrixXd torque_regressor(const Model& arm, const VectorRef& q, const VectorRef& dq,
                          const VectorRef& ddq);

}  // namespace veridyn
