#pragma once

#include <string>

#include "comparison/standard_torque.hpp"
#include "veridyn/comparison/model_comparison.hpp"

namespace veridyn {

/// A number with the digits that its deviation leaves it.
std::string number_text(double value, double deviation);

/// What a difference means: friction that grew, a first moment and the weight torque that goes with
/// it, an inertia that a joint feels.
///
/// @param standard  index of the standard parameter that leads the combination.
std::string parameter_sentence(const Model& arm, const StandardTorque& torque, int standard,
                               const ModelDifference& difference);

/// The same for what a joint feels.
std::string joint_sentence(const Model& arm, JointQuantity which,
                           const ModelDifference& difference);

}  // namespace veridyn
