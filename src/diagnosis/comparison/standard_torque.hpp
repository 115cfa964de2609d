#pragma once

#include <vector>

#include "veridyn/diagnosis/model_comparison.hpp"
#include "veridyn/identification/regressor_columns.hpp"

namespace veridyn {

/// A property of a joint's torque over standard_motion() that is linear in the parameters.
struct JointQuantity {
  ComparedQuantity quantity;
  const char* words;  ///< beginning of a sentence, before the joint
};

/// friction:     half the difference between the effects' mean torques in forward and in backward motion [N m];
/// offset:       half the sum of these two torques [N m];
/// weight:       mean torque that holds the bodies at rest in the poses of the motion [N m];
/// weight_slope: amplitude of that torque at the frequency of the joint's own motion [N m];
/// inertia:      mean of M_ii, rotor inertia included [kg m^2].
constexpr JointQuantity kJointQuantities[] = {{ComparedQuantity::kFriction, "Friction of"},
                                              {ComparedQuantity::kOffset, "The constant torque of"},
                                              {ComparedQuantity::kWeight, "The weight that rests on"},
                                              {ComparedQuantity::kWeightSlope, "The part of the weight that follows the position of"},
                                              {ComparedQuantity::kInertia, "The inertia of"}};

/// Torques over standard_motion() as a function of all standard parameters of an arm, known ones included.
struct StandardTorque {
  explicit StandardTorque(const Model& arm);

  /// Torques of one joint [N m] or [N], a column for each column of `values` (standard x any).
  MatrixXd torque(int joint, const MatrixRef& values) const;

  std::vector<StandardParameter> parameters;
  std::vector<JointRows> joints;     ///< rows of every joint in motion
  MatrixXd rms;                      ///< (n x standard) rms torque per unit of every parameter
  MatrixXd weight;                   ///< (n x standard) largest torque per unit, at rest in the poses of the motion
  /// Of every joint, the kJointQuantities (standard x 5) per unit of every parameter, over whole periods of its
  /// motion. Values far below a parameter's own torque are rounding errors and set to zero.
  std::vector<MatrixXd> quantities;
};

/// Root mean square of every column (n).
VectorXd rms(const MatrixRef& columns);

}  // namespace veridyn
