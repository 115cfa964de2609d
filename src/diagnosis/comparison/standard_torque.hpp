#pragma once

#include <vector>

#include "veridyn/identification/regressor_columns.hpp"
#include "veridyn/math/motion_samples.hpp"

namespace veridyn {

/// A quantity of a joint's torque that is linear in the parameters.
enum class JointQuantity {
  /// Half the difference of the effects' mean torques forward and backward over
  /// standard_motion() [N m].
  kFriction,
  kOffset,       ///< half the sum of the two [N m]
  kWeight,       ///< mean torque that holds the resting bodies in its poses [N m]
  kWeightSlope,  ///< amplitude with which that torque follows the joint's own sine [N m]
  kInertia,      ///< mean of M_ii, rotor inertia included [kg m^2]
};

constexpr JointQuantity kJointQuantities[] = {JointQuantity::kFriction, JointQuantity::kOffset,
                                              JointQuantity::kWeight, JointQuantity::kWeightSlope,
                                              JointQuantity::kInertia};

/// Torques over standard_motion() as a function of every standard parameter of an arm (facts as
/// well).
class StandardTorque {
 public:
  explicit StandardTorque(const Model& arm);

  const std::vector<StandardParameter>& parameters() const { return parameters_; }

  /// (rows x n) [N m] or [N].
  /// @param values  (standard).
  MatrixXd torque(const VectorRef& values) const;

  /// (n) rms torque per unit of one parameter.
  VectorXd rms_of(int parameter) const;

  /// (n) largest torque per unit of one parameter at rest in the same positions.
  VectorXd weight_of(int parameter) const;

  /// (standard) rms over all joints: the size of every parameter's column.
  VectorXd column_sizes() const;

  /// (standard) the quantity of a joint per unit of every parameter, over whole periods of the
  /// joint's motion; contributions far below a parameter's own torque are rounding and set to zero.
  VectorXd quantity(JointQuantity which, int joint) const;

 private:
  VectorXd projected(const JointRows& rows, const VectorXd& on, bool bodies) const;

  MotionSamples motion_;
  std::vector<StandardParameter> parameters_;
  std::vector<JointRows> moving_, resting_;
  std::vector<JointRows> speeding_up_;  ///< joint i alone has an acceleration of one, from rest
};

/// (n) root mean square of every column.
VectorXd rms(const MatrixRef& columns);

}  // namespace veridyn
