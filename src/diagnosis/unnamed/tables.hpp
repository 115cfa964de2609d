#pragma once

#include <vector>

#include "diagnosis/unnamed/motion_signals.hpp"
#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn {

/// The terms of a model that say what a curve without a name says: one table, or one for each part
/// of the second signal. Empty where its signals are none that a force may be a function of
/// (accelerations, times and ways since a reversal, torques of other joints).
/// @param of  the curve's signals.
std::vector<EffectTerm> tables_of(const Model& arm, JointIndex joint, const UnnamedShape& shape,
                                  const std::vector<MotionSignal>& of);

}  // namespace veridyn
