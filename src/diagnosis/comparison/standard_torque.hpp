#pragma once

#include <vector>

#include "veridyn/identification/regressor_columns.hpp"
#include "veridyn/math/motion_samples.hpp"

namespace veridyn {

/// A property of a joint's torque that is linear in the parameters.
enum class JointQuantity {
  /// Half the difference between the effects' mean torques in forward and in backward motion over
  /// standard_motion() [N m].
  kFriction,
  kOffset,       ///< half the sum of these two torques [N m]
  kWeight,       ///< mean torque that holds the bodies at rest in the poses of standard_motion() [N m]
  kWeightSlope,  ///< amplitude of that torque at the frequency of the joint's own motion [N m]
  kInertia,      ///< mean of M_ii, rotor inertia included [kg m^2]
};

constexpr JointQuantity kJointQuantities[] = {JointQuantity::kFriction, JointQuantity::kOffset,
                                              JointQuantity::kWeight, JointQuantity::kWeightSlope,
                                              JointQuantity::kInertia};

/// Torques over standard_motion() as a function of all standard parameters of an arm, known ones included.
/// well).
class StandardTorque {
 public:
  explicit StandardTorque(const Model& arm);

  const std::vector<StandardParameter>& parameters() const { return parameters_; }

  /// Torques (rows x n) [N m] or [N].
  /// @param values  (standard).
  MatrixXd torque(const VectorRef& values) const;

  /// Rms torque of each joint (n) per unit of one parameter.
  VectorXd rms_of(int parameter) const;

  /// Largest torque of each joint (n) per unit of one parameter, at rest in the poses of standard_motion().
  VectorXd weight_of(int parameter) const;

  /// Rms torque over all joints (standard) per unit of every parameter.
  VectorXd column_sizes() const;

  /// The quantity of a joint (standard) per unit of every parameter, over whole periods of the joint's
  /// motion. Values far below a parameter's own torque are rounding errors and set to zero.
  VectorXd quantity(JointQuantity which, int joint) const;

 private:
  VectorXd projected(const JointRows& rows, const VectorXd& on, bool bodies) const;

  MotionSamples motion_;
  std::vector<StandardParameter> parameters_;
  std::vector<JointRows> moving_, resting_;
  std::vector<JointRows> speeding_up_;  ///< joint i alone accelerates by one unit, from rest
};

/// Root mean square of every column (n).
VectorXd rms(const MatrixRef& columns);

}  // namespace veridyn
