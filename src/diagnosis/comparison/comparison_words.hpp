#pragma once

#include <string>

#include "diagnosis/comparison/standard_torque.hpp"
#include "veridyn/diagnosis/model_comparison.hpp"

namespace veridyn {

/// A difference in words: friction that grew, a first moment as a torque of weight, a joint's inertia.
///
/// @param standard  index of the standard parameter that leads the combination.
std::string parameter_sentence(const Model& arm, const StandardTorque& torque, int standard, const ModelDifference& difference);

/// The same for a quantity of a joint.
std::string joint_sentence(const Model& arm, const JointQuantity& which, const ModelDifference& difference);

}  // namespace veridyn
