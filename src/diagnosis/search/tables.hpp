#pragma once

#include <vector>

#include "diagnosis/search/motion_signals.hpp"
#include "veridyn/diagnosis/diagnosis.hpp"

namespace veridyn {

/// Terms that reproduce an unnamed curve: one table, or one for each window of the second signal. Empty if a
/// force cannot depend on its signals (accelerations, times, displacements since a reversal, torques of other
/// joints).
/// @param of  the curve's signals.
std::vector<EffectTerm> tables_of(const Model& arm, JointIndex joint, const UnnamedShape& shape,
                                  const std::vector<MotionSignal>& of);

}  // namespace veridyn
